"""Time in a bag against the clocks of now."""

import pytest

from mctrack_ros.ros.topics.pacing import Pace, shifted

PERIOD_NS = 40_000_000


def test_pace_relates_the_bag_to_the_steady_clock():
    pace = Pace(first_ns=1000, rate=2.0, began_ns=50, shift_ns=0)
    assert pace.due_ns(1000) == 50
    assert pace.due_ns(1200) == 150
    assert pace.bag_ns(150) == 1200


@pytest.mark.parametrize('order', ['little', 'big'])
def test_stamp_of_a_serialised_message_is_moved(order):
    head = b'\x00\x01\x00\x00' if order == 'little' else b'\x00\x00\x00\x00'
    data = head + (5).to_bytes(4, order) + (900_000_000).to_bytes(4, order) + b'rest'
    moved = shifted(data, 200_000_000 + PERIOD_NS)
    assert moved == head + (6).to_bytes(4, order) + (140_000_000).to_bytes(4, order) + b'rest'
