"""
PETS 2009 S2.L1, view 1, from pixels: one camera through the whole pipeline.

The parameters were chosen on frames 1 to 397; frames 398 to 795 are reported.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import config_from
from mctrack_ros.evaluation import Scores, Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion import JointConfig
from mctrack_ros.ground import ProjectiveMapping, read_tsai
from mctrack_ros.interfaces import CameraDetections, Feedback, Tick, Tracks
from mctrack_ros.perception import EventTracker, EventTrackerConfig, FeedbackBuffer
from mctrack_ros.recording.video.videos import open_video
from mctrack_ros.replay.drive import drive

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

IMAGE_SIZE = (480, 360)
PERIOD_S = 1 / 7
PERIOD_NS = round(PERIOD_S * 1e9)
FEEDBACK_DELAY_NS = 2 * PERIOD_NS
REPORTED_FRAMES = (398, 795)
GATE_M = 1.0
CAMERA = 'view1'

CAMERA_SETTINGS: dict[str, Any] = {
    'background': {'minimum_threshold': 22.0},
    'blobs': {'closing_px': 3, 'halo_share': 0.2},
}
FUSION_SETTINGS: dict[str, Any] = {
    'batching': {'period': PERIOD_S},
    'motion': {'acceleration_density': 1.0},
    'association': {'appearance_weight': 30.0},
    'management': {'tentative_time': 0.3, 'report_time': 0.5, 'coast_time': 3.0},
}
SETTINGS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    'pets.pixels': ({}, {'batching': {'period': PERIOD_S}}),
    'pets.pixels.tuned': (CAMERA_SETTINGS, FUSION_SETTINGS),
}
"""Of the camera and of fusion, by the prefix of their figures: defaults, and tuned ones."""


class TsaiCamera:
    """
    A camera calibrated after Tsai (1987): pose, pinhole, one radial distortion term.

    Parameters
    ----------
    path : Path
        XML file of the PETS calibration; lengths in mm, angles in rad.
    size : (int, int)
        Width and height of the images to be mapped, px; the calibrated size is scaled to it.

    """

    def __init__(self, path: Path, size: tuple[int, int]) -> None:
        stored = read_tsai(path)
        scale = size[0] / stored.image_size[0]
        self._size = size
        self._radial = stored.kappa1
        self._centre, self._per_mm = stored.centre * scale, stored.per_mm * scale
        across, down = stored.focal_mm * self._per_mm
        x, y = self._centre
        intrinsics = np.array([[across, 0, x], [0, down, y], [0, 0, 1]])
        pose = np.column_stack([stored.rotation, stored.translation])
        self.mapping = ProjectiveMapping(intrinsics @ pose, size)

    def undistortion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the maps with which `cv2.remap` makes the image that of a pinhole."""
        width, height = self._size
        column, row = np.meshgrid(np.arange(width), np.arange(height))
        ideal = (np.dstack([column, row]) - self._centre) / self._per_mm
        distorted = ideal.copy()
        for _ in range(10):
            square = (distorted**2).sum(axis=2, keepdims=True)
            distorted = ideal / (1 + self._radial * square)
        pixel = distorted * self._per_mm + self._centre
        return pixel[..., 0].astype(np.float32), pixel[..., 1].astype(np.float32)


def images(folder: Path, camera: TsaiCamera) -> Iterator[tuple[int, Image]]:
    """Yield the frame number, as the truth counts (from 1), and the undistorted image."""
    maps = camera.undistortion()
    video = open_video(folder / 'video' / 'vtest_480x360.avi')
    for frame, image in enumerate(video.images(), start=1):
        yield frame, np.asarray(cv2.remap(image, *maps, cv2.INTER_LINEAR), np.uint8)


def stamp_of(frame: int) -> int:
    """Return the stamp, ns, of a frame: the middle of its period."""
    return (2 * frame + 1) * PERIOD_NS // 2


def track(
    source: Iterable[tuple[int, Image]],
    mapping: ProjectiveMapping,
    camera_config: EventTrackerConfig,
    fusion_config: JointConfig,
) -> Iterator[Tracks]:
    """
    Take one camera's images through perception and fusion, feedback included.

    Parameters
    ----------
    source : iterable of (int, (h, w, 3) uint8 array)
        Frame numbers and images.
    mapping : ProjectiveMapping
        Of the camera.
    camera_config : EventTrackerConfig
        Parameters of perception.
    fusion_config : JointConfig
        Parameters of fusion.

    Yields
    ------
    Tracks
        One a frame.

    """
    camera = EventTracker(camera_config, mapping)
    buffer = FeedbackBuffer(PERIOD_NS, FEEDBACK_DELAY_NS)

    def ticks() -> Iterator[Tick]:
        for frame, image in source:
            feedback, _ = buffer.select(stamp_of(frame))
            detections = camera.step(image, stamp_of(frame), feedback).detections
            yield Tick.of([CameraDetections(CAMERA, detections)])

    for ticked in drive(fusion_config, (CAMERA,), ticks()):
        assert isinstance(ticked.feedback, Feedback)
        buffer.push(ticked.feedback)
        yield ticked.output.tracks


def read_truth(folder: Path) -> Trajectories:
    """Read the truth, frames from 1, metres; rows of confidence 0 are to be ignored."""
    table = np.loadtxt(folder / 'gt' / '3DMOT2015_PETS09-S2L1_gt.txt', delimiter=',')
    return Trajectories(
        frame=table[:, 0].astype(np.int64),
        id=table[:, 1].astype(np.int64),
        position=table[:, 7:9],
        ignore=table[:, 6] == 0,
    )


def score(instants: Iterable[Tracks], truth: Trajectories, frames: tuple[int, int]) -> Scores:
    """
    Compare tracks with the truth of some frames, first and last included.

    Tracks outside the rectangle that all of the truth spans are left out: nobody is annotated
    there.
    """
    tracks = Trajectories.from_tracks(instants, PERIOD_NS)
    low, high = truth.position.min(axis=0), truth.position.max(axis=0)
    covered = ((tracks.position >= low) & (tracks.position <= high)).all(axis=1)
    wanted = range(frames[0], frames[1] + 1)
    return evaluate_ground(
        truth.at_frames(wanted), tracks.select(covered).at_frames(wanted), GATE_M
    )


def pets_pixels(folder: Path) -> Figures:
    """
    Track PETS view 1 from its video and compare with the truth on the ground.

    Parameters
    ----------
    folder : Path
        The data set's.

    """
    camera = TsaiCamera(folder / 'calibration' / 'View_001.xml', IMAGE_SIZE)
    truth = read_truth(folder)
    figures: dict[str, float] = {}
    for prefix, (perception, fusion) in SETTINGS.items():
        tracks = track(
            images(folder, camera),
            camera.mapping,
            config_from(EventTrackerConfig, perception),
            config_from(JointConfig, fusion),
        )
        scores = score(tracks, truth, REPORTED_FRAMES)
        figures |= {
            f'{prefix}.moda': scores.moda,
            f'{prefix}.mota': scores.mota,
            f'{prefix}.idf1': scores.idf1,
            f'{prefix}.hota': scores.hota,
            f'{prefix}.switches': scores.switches,
            f'{prefix}.error_m': scores.mean_distance,
            f'{prefix}.precision': scores.precision,
            f'{prefix}.recall': scores.recall,
        }
    protocol = {
        'data': 'PETS 2009 S2.L1, view 1, 480 x 360 px, 7 fps, from pixels',
        'frames': '398-795',
        'gate': '1 m on the ground',
        'area': 'rectangle that the truth spans; truth of confidence 0 is ignored',
        'settings': 'defaults; stated are calibration and rate',
        'tuned': f'beside, chosen on frames 1-397: {CAMERA_SETTINGS}, {FUSION_SETTINGS}',
    }
    return Figures('pets.pixels', 'mctrack reproduce pets', protocol, figures)
