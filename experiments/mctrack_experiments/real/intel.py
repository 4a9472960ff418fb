"""
Two clips of Intel's, one camera each: how many cars and people pass, by eye and by silhouettes.

There is no annotation and no calibration: the objects were counted by eye, and the cameras'
heights, tilts and focal lengths are guesses that make cars 1.8 m wide and people 1.7 m tall.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros.config import config_from
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.silhouettes import SilhouetteConfig, SilhouettePipeline
from mctrack_ros.recording.video.videos import open_video

FOLDER = 'intel_sample_videos'
SIZE = (768, 432)
SETTLING_S = 1.0
"""Until then the cameras have not come to rest; nobody is in the images yet."""

TUNED: dict[str, Any] = {
    'background': {'shadow_share': 0.35, 'threshold': 12.0},  # shadows under cars; compressed
    'holes': {'edge_ratio': 0.0},  # both scenes are empty at first: nothing can leave a hole
    'absorption': {'rest_s': 60.0, 'pedestrian_rest_s': 60.0},  # people stand for up to 25 s
}


@dataclass(frozen=True, slots=True)
class Clip:
    """
    One of the clips.

    Attributes
    ----------
    file : str
        In the data set's folder.
    rate_hz : float
        Images a second.
    height_m, tilt_deg, focal_px : float
        Of the camera, guessed: above the ground, down from the horizontal, focal length.
    true : int
        Objects counted by eye.

    """

    file: str
    rate_hz: float
    height_m: float
    tilt_deg: float
    focal_px: float
    true: int

    def mapping(self) -> ProjectiveMapping:
        """Return the guessed camera, which looks along y from above the origin."""
        tilt = np.deg2rad(self.tilt_deg)
        right, forward = np.array([1.0, 0, 0]), np.array([0, np.cos(tilt), -np.sin(tilt)])
        rotation = np.stack([right, np.cross(forward, right), forward])
        focal, (width, height) = self.focal_px, SIZE
        intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        pose = np.column_stack([rotation, -rotation @ [0, 0, self.height_m]])
        return ProjectiveMapping(intrinsics @ pose, SIZE)


CARS = Clip('car-detection.mp4', 12.5, 7.4, 38.8, 900.0, 4)
PEOPLE = Clip('one-by-one-person-detection.mp4', 10.0, 2.4, 32.0, 700.0, 6)


@dataclass(frozen=True, slots=True)
class Counts:
    """What a tracker counted: vehicles, pedestrians, and others too short to be passed on."""

    vehicles: int
    pedestrians: int
    short: int


def counted(folder: Path, clip: Clip, settings: Mapping[str, Any]) -> Counts:
    """
    Track a clip and count what was tracked.

    Parameters
    ----------
    folder : Path
        The data set's.
    clip : Clip
        Which.
    settings : mapping
        Of the tracker; what it leaves out is as by default.

    """
    pipeline = SilhouettePipeline(config_from(SilhouetteConfig, settings), clip.mapping())
    images: dict[int, int] = {}
    as_vehicle: dict[int, int] = {}
    passed: set[int] = set()
    for index, image in enumerate(open_video(folder / clip.file).images(), start=1):
        if index < SETTLING_S * clip.rate_hz:
            continue
        pipeline.step(image, round(index / clip.rate_hz * 1e9), None)
        objects = pipeline.objects
        passed.update(objects.local_id[objects.passed_on].tolist())
        for row in np.flatnonzero(objects.established & objects.matched).tolist():
            key = int(objects.local_id[row])
            images[key] = images.get(key, 0) + 1
            vehicle = objects.class_id[row] == ClassCode.VEHICLE
            as_vehicle[key] = as_vehicle.get(key, 0) + int(vehicle)
    vehicles = {key for key, count in images.items() if 2 * as_vehicle[key] > count}
    people = passed - vehicles
    return Counts(len(vehicles), len(people), len(images.keys() - vehicles - people))


def reproduce_intel(data: Path) -> Figures:
    """Count the cars of one clip and the people of the other, by default and tuned."""
    protocol = {
        'data': 'Intel IoT DevKit sample videos (CC BY 4.0): car-detection, '
        'one-by-one-person-detection; 768 x 432 px, 12.5 and 10 images a second, all of them '
        f'but the first {SETTLING_S:g} s, in which the cameras still move',
        'true, by eye': f'{CARS.true} cars and nobody else; {PEOPLE.true} people, no vehicle',
        'cameras': 'guessed: 7.4 m up, tilted 38.8 degrees, 900 px; 2.4 m, 32 degrees, 700 px',
        'tracker': 'silhouettes, as by default',
        'tuned': 'a shadow may take 35 % of the light, what differs by 12 grey levels is '
        'foreground, what rests is background after 60 s, holes are not looked for: chosen while '
        'looking at these very clips',
        'counted': 'established tracks that were vehicles for most of their time; other tracks '
        'that were passed on (3 s of coherent track); short: other tracks that were not',
        'wrong': 'objects too many or too few, of either kind, in both clips',
    }
    figures: dict[str, float] = {'cars.true': CARS.true, 'people.true': PEOPLE.true}
    for name, settings in (('default', {}), ('tuned', TUNED)):
        cars, people = (counted(data / FOLDER, clip, settings) for clip in (CARS, PEOPLE))
        wrong = abs(cars.vehicles - CARS.true) + cars.pedestrians
        wrong += abs(people.pedestrians - PEOPLE.true) + people.vehicles
        figures |= {
            f'{name}.wrong': wrong,
            f'{name}.cars': cars.vehicles,
            f'{name}.cars.pedestrians': cars.pedestrians,
            f'{name}.cars.short': cars.short,
            f'{name}.people': people.pedestrians,
            f'{name}.people.vehicles': people.vehicles,
            f'{name}.people.short': people.short,
        }
    return Figures('intel', 'mctrack reproduce intel', protocol, figures)
