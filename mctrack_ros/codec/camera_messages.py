"""Messages of camera nodes of every kind: encoded as ROS messages, decoded back."""

from __future__ import annotations

from typing import Any

from mctrack_ros.codec.clouds import cloud_from_rows, rows_from_cloud
from mctrack_ros.codec.foreground import foreground_from_png, png_from_foreground
from mctrack_ros.codec.messages import MessageClasses
from mctrack_ros.interfaces import Foreground, Message


def ros_from_message(message: Message, classes: MessageClasses, frame_id: str) -> Any:
    """Encode rows as a cloud, a mask as a PNG."""
    if isinstance(message, Foreground):
        return png_from_foreground(message, classes, frame_id)
    return cloud_from_rows(message, classes, frame_id)  # type: ignore[arg-type]


def message_from_ros(ros: Any, kind: type[Any]) -> Any:
    """
    Decode a message of one of the kinds that camera nodes publish.

    Raises
    ------
    CodecError
        If it does not hold that.

    """
    return foreground_from_png(ros) if kind is Foreground else rows_from_cloud(ros, kind)
