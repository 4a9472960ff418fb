import numpy as np

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.local_tracks.classification import (
    ClassConfig,
    ClassVotes,
    looks_like_bicycle,
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


RIDES = {
    'from the side': ((1.1, 1.7), 0.37, 4.0, True),
    'all of the wheels seen': ((1.8, 1.7), 0.3, 3.0, True),
    'pushed': ((1.1, 1.7), 0.37, 1.4, False),
    'speed not known': ((1.1, 1.7), 0.37, -1.0, False),
    'from the front': ((0.6, 1.7), 0.5, 4.0, False),
    'two who run': ((1.3, 1.8), 0.6, 4.0, False),
    'a low car': ((3.5, 1.4), 0.4, 4.0, False),
}


def test_length_speed_and_what_is_seen_through_tell_bicycles():
    extent, fill, speed, expected = map(np.array, zip(*RIDES.values()))
    assert looks_like_bicycle(extent, fill, speed).tolist() == expected.tolist()


def counted(votes, look, whole=True, times=1):
    for _ in range(times):
        found = votes.count(np.array([7]), np.array([look]), np.array([whole]), 0.25)
    return int(found[0])


PERSON, BICYCLE, VEHICLE = ClassCode.PERSON, ClassCode.BICYCLE, ClassCode.VEHICLE


def test_most_of_the_time_counts_but_not_while_it_is_cut_or_merged():
    votes = ClassVotes()
    assert counted(votes, PERSON, whole=False, times=9) == PERSON
    assert counted(votes, VEHICLE, times=3) == VEHICLE
    assert counted(votes, PERSON) == VEHICLE
    assert counted(votes, PERSON, times=4) == PERSON


def test_a_long_past_does_not_count_for_ever():
    votes = ClassVotes()
    counted(votes, VEHICLE, times=400)
    assert counted(votes, PERSON, times=13) == PERSON


def test_the_lead_passes_to_whichever_class_outlasts_it():
    votes = ClassVotes()
    counted(votes, PERSON, times=2)
    assert counted(votes, BICYCLE, times=2) == BICYCLE
    assert counted(votes, VEHICLE) == VEHICLE
    counted(votes, BICYCLE, times=2)
    kind, lead = votes.leads(np.array([7, 8]))
    assert kind.tolist() == [BICYCLE, 0]
    assert lead.tolist() == [0.25, 0.0]
