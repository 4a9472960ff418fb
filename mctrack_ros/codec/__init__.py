"""
Interfaces and images to ROS messages and back: the only code that knows message fields.

The message classes come as an argument, so the same code serves rclpy and rosbags.
"""

from mctrack_ros.codec.camera_messages import message_from_ros, ros_from_message
from mctrack_ros.codec.clouds import (
    cloud_from_rows,
    fields_of_cloud,
    further_fields,
    rows_from_cloud,
)
from mctrack_ros.codec.images import (
    compressed_message,
    image_from_message,
    image_message,
    jpeg_from_image,
)
from mctrack_ros.codec.messages import CodecError, MessageClasses, header, stamp_ns_of

__all__ = [
    'CodecError',
    'MessageClasses',
    'cloud_from_rows',
    'compressed_message',
    'fields_of_cloud',
    'further_fields',
    'header',
    'image_from_message',
    'image_message',
    'jpeg_from_image',
    'message_from_ros',
    'ros_from_message',
    'rows_from_cloud',
    'stamp_ns_of',
]
