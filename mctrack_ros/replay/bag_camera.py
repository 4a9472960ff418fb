"""A camera's calibration from a bag: its `CameraInfo` and TF."""

from __future__ import annotations

from pathlib import Path

from mctrack_ros.ground import CalibrationError, HeardCamera, StoredCamera
from mctrack_ros.recording import BagReader

TF_TOPICS = ('/tf', '/tf_static')
_INFO = 'sensor_msgs/msg/CameraInfo'
_TF = 'tf2_msgs/msg/TFMessage'


def camera_from_bag(path: str | Path, topic: str, heard: HeardCamera) -> StoredCamera:
    """
    Return the first camera that a bag describes completely.

    Parameters
    ----------
    path : str or Path
        The bag.
    topic : str
        Of its `CameraInfo`; may be empty if the bag has one alone.
    heard : HeardCamera
        What is known of it.

    Raises
    ------
    BagError, CalibrationError
        If the bag cannot be read, the info holds no calibration, or something is missing.

    """
    with BagReader(path) as bag:
        topic = topic or _only_topic(bag)
        if bag.topics.get(topic, _INFO) != _INFO:
            raise CalibrationError(f'{path}: {topic} holds no {_INFO} but {bag.topics[topic]}')
        transforms = [name for name in TF_TOPICS if bag.topics.get(name) == _TF]
        try:
            for name, message, _ in bag.messages([topic, *transforms]):
                (heard.hear_info if name == topic else heard.hear_transforms)(message)
                camera = heard.camera()
                if camera is not None:
                    return camera
        except CalibrationError as error:
            raise CalibrationError(f'{path}: {topic}: {error}') from error
    raise CalibrationError(f'{path}: {topic}: {heard.missing()}')


def _only_topic(bag: BagReader) -> str:
    topics = sorted(name for name, kind in bag.topics.items() if kind == _INFO)
    if len(topics) != 1:
        found = ', '.join(topics) or 'none'
        raise CalibrationError(
            f"{bag.path}: which topic holds the camera's info? Name it by --topic ({_INFO} on: "
            f'{found})'
        )
    return topics[0]
