import numpy as np
import pytest

from mctrack_ros.perception.blob_split.measurements import Observations
from mctrack_ros.perception.local_tracks.update import LearningRates, learn

STAMP_NS = 10**18
TABLE = np.tile([20.0, 40.0, 0.0], (64, 64, 1))  # px to a metre, across and upright
PACE = LearningRates(size=0.5, colours=0.5)


class Pupils:
    """Two tracks that know nothing yet, and one person who is seen."""

    def __init__(self):
        self.seen_ns, self.clear_ns = np.zeros(2, np.int64), np.zeros(2, np.int64)
        self.extent, self.template = np.zeros((2, 2)), np.zeros((2, 48))

    def see(self, track=1, fitted=False, visible=1.0, own_share=1.0, truncated=False):
        seen = Observations(
            np.array([track]),
            np.zeros(1, np.int64),
            np.array([[90.0, 60.0, 20.0, 40.0]]),
            np.array([[100.0, 100.0]]),
            np.zeros((1, 2)),
            np.zeros((1, 2, 2)),
            np.array([visible]),
            np.array([own_share]),
            np.ones((1, 48)),
            np.array([fitted]),
            np.zeros((1, 2)),
        )
        measured = learn(
            seen,
            np.array([truncated]),
            STAMP_NS,
            TABLE,
            PACE,
            self.seen_ns,
            self.clear_ns,
            self.extent,
            self.template,
        )
        return measured.tolist()


@pytest.fixture
def pupils():
    return Pupils()


def test_who_is_alone_in_a_blob_teaches_place_size_and_colours(pupils):
    assert pupils.see() == [1]
    assert pupils.extent.tolist() == [[0, 0], [0.5, 0.5]]
    assert (pupils.template[1] == 0.5).all()
    assert not pupils.template[0].any()
    assert pupils.seen_ns.tolist() == pupils.clear_ns.tolist() == [0, STAMP_NS]


def test_who_is_cut_off_by_the_edge_teaches_no_size(pupils):
    assert pupils.see(truncated=True) == [1]
    assert not pupils.extent.any()
    assert pupils.template.any()


def test_a_body_in_a_shared_blob_teaches_its_place_alone(pupils):
    assert pupils.see(fitted=True) == [1]
    assert not pupils.extent.any()
    assert not pupils.template.any()


def test_a_hidden_body_is_seen_and_not_measured(pupils):
    assert pupils.see(fitted=True, visible=0.1, own_share=0.1) == [-1]
    assert (pupils.seen_ns[1], pupils.clear_ns[1]) == (STAMP_NS, 0)


def test_a_stranger_teaches_nobody(pupils):
    assert pupils.see(track=-1) == [-1]
    assert not pupils.seen_ns.any()
    assert not pupils.template.any()
