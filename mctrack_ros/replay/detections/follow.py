"""How a camera that moves looked at the images in which somebody's detector saw people."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mctrack_ros.codec import image_from_message, stamp_ns_of
from mctrack_ros.ground import GroundMapping, ProjectiveMapping
from mctrack_ros.perception.moving_camera.moving_camera import CameraMotion, MovingCamera
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tables.sightings import Sightings
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.names import named_image_topic, resolved

SAME_NS = 5_000_000
"""An image is that of a detection if their stamps differ by no more, ns."""


def followed(
    camera: str, settings: CameraSettings, bag: str | Path, sightings: Sightings
) -> dict[int, GroundMapping]:
    """
    Follow a camera that moves through its images.

    Parameters
    ----------
    camera : str
        Its name.
    settings : CameraSettings
        With the calibration of the first image, and lines.
    bag : str or Path
        With the images.
    sightings : Sightings
        What was seen in them; their boxes are no features.

    Returns
    -------
    dict of int to GroundMapping
        By the stamps of the sightings, ns; those without an image, or in whose image the camera
        is lost, are missing.

    Raises
    ------
    BagError, CalibrationError, ConfigError, TableError
        If the bag or the calibration cannot be used: a pinhole camera is expected.

    """
    mapping = settings.mapping()
    if not isinstance(mapping, ProjectiveMapping):
        raise TableError(
            f'{camera} moves and its calibration has a lens or no pose: expected a pinhole '
            'camera of the first image, for example method: homography'
        )
    moving = MovingCamera(mapping, settings.painted_lines())
    size, stamps = (settings.image_width, settings.image_height), sightings.stamp_ns
    topic = resolved(named_image_topic(camera, settings.image_topic))
    looks: dict[int, GroundMapping] = {}
    with BagReader(bag) as reader:
        if not reader.count(topic):
            raise TableError(f'{bag} has no images on {topic}: {camera} moves and needs them')
        for _, message, _ in reader.messages([topic]):
            index = int(np.abs(stamps - stamp_ns_of(message)).argmin())
            is_same = abs(int(stamps[index]) - stamp_ns_of(message)) <= SAME_NS
            box = sightings.box[(sightings.image == index) & is_same]
            try:
                image = image_from_message(message, size)
            except ValueError:
                continue
            view = moving.step(image, box[np.isfinite(box).all(axis=1)])
            if is_same and view.state is CameraMotion.TRACKED:
                looks[int(stamps[index])] = view.mapping
    return looks
