"""Where `mctrack convert-calibration` takes a calibration from: a file, a bag, a running graph."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from mctrack_ros.ground import (
    GroundMapping,
    HeardCamera,
    StoredCamera,
    camera_mapping,
    read_calibration,
    read_extrinsics,
    stated_size,
)

_TOPIC = re.compile(r'(/[A-Za-z_]\w*)+')


@dataclass(frozen=True, slots=True)
class Heard:
    """How a camera is heard: its topic in a bag, the ground frame, how long to wait, s."""

    topic: str
    frame: str
    timeout_s: float


def read_source(
    source: str, size: tuple[int, int] | None, extrinsics: str | Path, unit: str, heard: Heard
) -> tuple[GroundMapping, str]:
    """
    Read a calibration from where it is.

    Parameters
    ----------
    source : str
        A file, a bag, or what is neither and can be a topic.
    size : (int, int) or None
        Of the pictures, px, if it was stated.
    extrinsics : str or Path
        File with the camera's pose; may be empty.
    unit : str
        Of lengths in files.
    heard : Heard
        For a bag or a topic.

    Returns
    -------
    mapping : GroundMapping
        The calibration.
    name : str
        Of the camera.

    Raises
    ------
    ValueError
        If a topic is named for what is no bag, or the size of the pictures is not known.
    CalibrationError, BagError
        If there is no calibration; says why.

    """
    from mctrack_ros.recording import is_bag

    path = Path(source)
    is_topic = not path.exists() and _TOPIC.fullmatch(source) is not None
    if is_bag(path) or is_topic:
        camera = _heard(source, is_topic, extrinsics, heard)
        if unit != 'm' and not extrinsics:
            raise ValueError(f'TF is in metres, not {unit}')
        mapping = camera_mapping(camera, source, size or camera.image_size or (0, 0), unit)
        return mapping, _name(source if is_topic else heard.topic)
    if heard.topic:
        raise ValueError(f'{source} is no bag, so it has no topic {heard.topic}')
    size = size or stated_size(source)
    if size is None:
        raise ValueError(f'{source} does not say how large the pictures are: name it with --size')
    return read_calibration(source, size, extrinsics, unit), path.stem


def _heard(source: str, is_topic: bool, extrinsics: str | Path, heard: Heard) -> StoredCamera:
    camera = HeardCamera(heard.frame, read_extrinsics(extrinsics) if extrinsics else None)
    if is_topic:
        from mctrack_ros.ros.hear_camera import camera_from_topic

        return camera_from_topic(source, camera, heard.timeout_s)
    from mctrack_ros.replay.bag_camera import camera_from_bag

    return camera_from_bag(source, heard.topic, camera)


def _name(topic: str) -> str:
    """Return the camera that a topic belongs to: what its last part hangs on."""
    return topic.strip('/').rpartition('/')[0].rpartition('/')[2] or 'camera'
