import numpy as np

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.classes import (
    ClassConfig,
    ClassVotes,
    looks_like_vehicle,
)

SIZES = {
    'pedestrian': ((0.5, 1.75), False),
    'in stride': ((1.0, 1.8), False),
    'two people': ((1.3, 1.9), False),
    'end of a car': ((1.8, 2.0), True),
    'side of a car': ((4.2, 1.9), True),
    'side of a low part of a car': ((3.0, 0.8), True),
}


def test_size_on_the_ground_tells_pedestrians_from_vehicles():
    extent = np.array([size for size, _ in SIZES.values()])
    expected = [vehicle for _, vehicle in SIZES.values()]
    assert looks_like_vehicle(extent, ClassConfig()).tolist() == expected


def counted(votes, size, whole=True, times=1):
    for _ in range(times):
        found = votes.count(np.array([7]), np.array([size]), np.array([whole]), 0.25)
    return int(found[0])


def test_most_of_the_time_counts_but_not_while_it_is_cut_or_merged():
    votes = ClassVotes(ClassConfig())
    assert counted(votes, (0.5, 1.7), whole=False, times=9) == ClassCode.PERSON
    assert counted(votes, (4.2, 1.9), times=3) == ClassCode.VEHICLE
    assert counted(votes, (0.5, 1.7)) == ClassCode.VEHICLE
    assert counted(votes, (0.5, 1.7), times=4) == ClassCode.PERSON


def test_a_long_past_does_not_count_for_ever():
    votes = ClassVotes(ClassConfig(memory_s=3.0))
    counted(votes, (4.2, 1.9), times=400)
    assert counted(votes, (0.5, 1.7), times=13) == ClassCode.PERSON
