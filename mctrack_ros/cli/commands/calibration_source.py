"""Where `mctrack convert-calibration` takes a calibration from: a file, a bag, a running graph."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from mctrack_ros.ground import (
    Choice,
    GroundMapping,
    HeardCamera,
    StoredCamera,
    camera_mapping,
    holds_camera,
    read_calibration,
    read_camera,
    read_extrinsics,
    stated_size,
)

_TOPIC = re.compile(r'(/[A-Za-z_]\w*)+')


@dataclass(frozen=True, slots=True)
class Heard:
    """How to receive a camera: its topic in a bag or file, the ground frame, the timeout, s."""

    topic: str
    frame: str
    timeout_s: float


def read_source(
    source: str, size: tuple[int, int] | None, extrinsics: str | Path, unit: str, heard: Heard
) -> tuple[GroundMapping, str, tuple[str, ...]]:
    """
    Read a calibration from where it is.

    Parameters
    ----------
    source : str
        A file, a bag, or what is neither and can be a topic.
    size : (int, int) or None
        Of the images, px, if it was stated.
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
    notes : tuple of str
        What the source states and the calibration leaves out.

    Raises
    ------
    ValueError
        If the size of the images is not known.
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
        return mapping, _name(source if is_topic else heard.topic), camera.notes
    choice = Choice(heard.topic)
    size = size or stated_size(source, choice)
    if size is None:
        raise ValueError(f'{source} does not say how large the images are: name it with --size')
    mapping = read_calibration(source, size, extrinsics, unit, choice)
    notes = read_camera(source, size, choice=choice).notes if holds_camera(source) else ()
    return mapping, path.stem, notes


def _heard(source: str, is_topic: bool, extrinsics: str | Path, heard: Heard) -> StoredCamera:
    camera = HeardCamera(heard.frame, read_extrinsics(extrinsics) if extrinsics else None)
    if is_topic:
        from mctrack_ros.ros.topics.hear_camera import camera_from_topic

        return camera_from_topic(source, camera, heard.timeout_s)
    from mctrack_ros.replay.bag_camera import camera_from_bag

    return camera_from_bag(source, heard.topic, camera)


def _name(topic: str) -> str:
    """Return the camera that a topic belongs to: the topic without its last part."""
    return topic.strip('/').rpartition('/')[0].rpartition('/')[2] or 'camera'
