"""Time in a bag against the clocks of now."""

import threading
import time

import pytest

from mctrack_ros.ros.playback.pacing import Due, Pace, Transport, shifted

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


class Played:
    """Messages 0.1 s apart that a transport lets go, in a thread."""

    def __init__(self, transport, count=50):
        self.transport, self.count = transport, count
        self.gone, self.told, self.ended = [], [], None
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        index = 0
        while index < self.count:
            self.transport.begin(Pace(index * 10**8, self.transport.rate, time.monotonic_ns(), 0))
            while index < self.count:
                due = self.transport.wait(index * 10**8, 10**7, self.told.append)
                if due is Due.JUMP:
                    index = self.transport.taken_jump() // 10**8
                    break
                if due is Due.END:
                    self.ended = due
                    return
                self.gone.append((index, time.monotonic()))
                index += 1

    def until(self, condition):
        end = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < end
            time.sleep(0.002)

    def indices(self):
        return [index for index, _ in self.gone]


def test_a_paused_player_steps_goes_on_and_jumps():
    transport = Transport(50.0, True)
    played = Played(transport)
    played.until(lambda: len(played.told) > 3)
    assert played.gone == []
    assert set(played.told) == {0}
    transport.step(3)
    played.until(lambda: len(played.gone) == 3)
    transport.jump(40 * 10**8)
    transport.pause(False)
    played.thread.join()
    assert played.indices() == [0, 1, 2, *range(40, 50)]


def test_the_speed_changes_from_there_on_and_a_player_ends_in_the_middle():
    transport = Transport(0.001, False)
    played = Played(transport)
    played.until(lambda: len(played.gone) == 1)
    transport.set_rate(100.0)
    played.until(lambda: len(played.gone) > 10)
    transport.pause(True)
    assert transport.is_paused
    at_ns = transport.at_ns
    assert at_ns >= 9 * 10**8
    transport.end()
    played.thread.join()
    assert played.ended is Due.END
    assert transport.at_ns >= at_ns
    seconds = played.gone[10][1] - played.gone[1][1]
    assert seconds >= 0.004


def test_a_burst_says_how_many_went_and_takes_back_the_rest():
    transport = Transport(1.0, True)
    assert transport.burst(2) == 0  # nothing plays yet
    played = Played(transport, count=6)
    assert transport.burst(2) == 2
    transport.pause(False)
    assert transport.burst(2) == 0
    transport.pause(True)
    ended = threading.Thread(target=lambda: (played.thread.join(), transport.end()))
    ended.start()
    assert 2 <= transport.burst(100) <= 4
    assert sorted(set(played.indices())) == [*range(6)]
