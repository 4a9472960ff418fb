"""Message types by name."""

import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import String

from mctrack_ros.ros.topics.messages import RCLPY_CLASSES, message_class, starts_with_header


def test_a_type_is_found_by_its_name():
    assert message_class('sensor_msgs/msg/CompressedImage') is CompressedImage


@pytest.mark.parametrize('kind', ['no_msgs/msg/Thing', 'std_msgs/msg/Thing', 'nonsense'])
def test_a_type_that_is_not_installed_is_refused(kind):
    with pytest.raises(ValueError, match=f"message type '{kind}' is not installed"):
        message_class(kind)


def test_messages_with_a_header_first_are_known():
    assert starts_with_header(CompressedImage)
    assert not starts_with_header(String)


def test_octets_hold_the_bytes_of_an_array():
    octets = RCLPY_CLASSES.octets(np.array([1, 2, 255], np.uint8))
    assert octets.typecode == 'B'
    assert octets.tolist() == [1, 2, 255]
