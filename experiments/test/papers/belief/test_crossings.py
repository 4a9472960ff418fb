"""Who passes whom, and who keeps them."""

import numpy as np
import pytest

from mctrack_experiments.papers.belief.crossings import AFTER_FRAMES, crossings, is_kept
from mctrack_ros.evaluation import Trajectories

FRAMES = np.arange(100)


def paths(ids):
    """Return two who pass each other at frame 50, as tracks of (frame, 2) ids."""
    along = (FRAMES - 50) * 0.1
    position = np.concatenate(
        [np.column_stack([along, 0 * along]), np.column_stack([-along, 0 * along + 0.3])]
    )
    return Trajectories(
        frame=np.tile(FRAMES, 2), id=np.concatenate(np.transpose(ids)), position=position
    )


TRUTH = paths([(1, 2)] * 100)


def test_a_crossing_lasts_from_before_they_are_near_to_after():
    ((one, other, begin, end),) = crossings(TRUTH)
    assert (one, other) == (1, 2)
    near = 4  # frames to either side: 2 x 0.1 m a frame, 0.3 m apart
    assert begin == pytest.approx(50 - near - AFTER_FRAMES, abs=1)
    assert end == pytest.approx(50 + near + AFTER_FRAMES, abs=1)
    assert not crossings(TRUTH.at_frames(range(30, 100)))


def test_it_is_kept_by_tracks_that_stay_with_their_person():
    (crossing,) = crossings(TRUTH)
    assert is_kept(crossing, TRUTH, paths([(7, 8)] * 100))
    assert not is_kept(crossing, TRUTH, paths([(7, 8)] * 50 + [(8, 7)] * 50))
    assert not is_kept(crossing, TRUTH, paths([(7, 8)] * 50 + [(7, 9)] * 50))
    assert not is_kept(crossing, TRUTH, paths([(7, 8)] * 100).at_frames(range(50)))
