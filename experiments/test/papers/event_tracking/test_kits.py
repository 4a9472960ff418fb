import pytest

from mctrack_experiments.papers.event_tracking.kits import score_kits
from mctrack_ros.interfaces import Tracks, TrackStatus


def people(kits, stamp_ns=0, shift=0.0, status=TrackStatus.CONFIRMED):
    return Tracks.build(
        stamp_ns,
        position=[(10.0 * index + shift, 0.0, 0.0) for index in range(len(kits))],
        track_id=range(1, len(kits) + 1),
        kit=kits,
        status=[status] * len(kits),
    )


TRUTH = people([1, 1, 1, 2, 2, 3])


@pytest.mark.parametrize(
    ('told', 'found', 'purity', 'share'),
    [
        ([5, 5, 5, 2, 2, 9], 3, 1.0, 1.0),  # names do not matter
        ([5, 5, 0, 2, 2, 9], 3, 1.0, 5 / 6),
        ([5, 5, 4, 2, 2, 9], 4, 1.0, 1.0),  # a kit in two parts is pure
        ([5, 5, 5, 5, 2, 9], 3, 5 / 6, 1.0),
        ([1, 1, 1, 1, 1, 1], 1, 3 / 6, 1.0),
        ([0, 0, 0, 0, 0, 0], 0, 0.0, 0.0),
    ],
)
def test_purity_counts_who_wears_what_most_do(told, found, purity, share):
    score = score_kits([TRUTH], [people(told, shift=0.5)], 1.0)
    assert (score.found, score.purity, score.told) == pytest.approx((found, purity, share))


def test_only_tracks_near_someone_and_of_that_stamp_count():
    far = people([1, 2, 3, 1, 2, 3], shift=3.0)
    later = people([1, 2, 3, 1, 2, 3], stamp_ns=1)
    tentative = people([1, 2, 3, 1, 2, 3], status=TrackStatus.TENTATIVE)
    for tracks in (far, later, tentative):
        assert score_kits([TRUTH], [tracks], 1.0).told == 0.0
