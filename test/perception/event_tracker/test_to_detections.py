import numpy as np
import pytest

from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.blob_split.measurements import Observations
from mctrack_ros.perception.blobs.extraction import Blobs
from mctrack_ros.perception.event_tracker.to_detections import confirmed_tracks, reported_persons
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import FilterConfig, LocalTracks

SECOND_NS = 1_000_000_000


def person(fitted=False, visible=1.0):
    """One person of track 1, in blob 0."""
    return Observations(
        np.array([1]),
        np.array([0]),
        np.array([[10.0, 20.0, 4.0, 10.0]]),
        np.zeros((1, 2)),
        np.array([[3.0, 4.0]]),
        np.zeros((1, 2, 2)),
        np.array([visible]),
        np.ones(1),
        np.full((1, 48), 0.25),
        np.array([fitted]),
        np.zeros((1, 2)),
    )


@pytest.fixture
def sizes(mapping):
    return SizeTable(mapping)


@pytest.fixture
def tracks_of(mapping, sizes):
    """Return what makes tracks with ids 5, 6, ..., as many as each column has rows."""

    def begin(**columns):
        tracks = LocalTracks(FilterConfig(), mapping, sizes)
        tracks._next_id = 5
        tracks.append(len(columns['first_ns']), **columns)
        return tracks

    return begin


@pytest.fixture
def reported(tracks_of, sizes):
    """Return what reports a person of the second of two tracks."""

    def report(seen, age_s=1.0, truncated=True):
        tracks = tracks_of(
            first_ns=np.array([0, round((5 - age_s) * SECOND_NS)]),
            track_id=np.array([0, 70]),
            template=np.full((2, 48), 0.5),
        )
        nowhere = np.zeros((1, 2))
        blobs = Blobs(
            np.zeros((1, 4)), np.array([33.0]), nowhere, nowhere, nowhere, np.array([truncated])
        )
        columns = reported_persons(seen, tracks, blobs, sizes, 5 * SECOND_NS, 0.2)
        return Detections.build(5 * SECOND_NS, **columns)

    return report


def test_a_blob_is_told_with_its_own_area_and_the_ids_of_its_track(reported):
    row = reported(person())
    assert (row.area[0], row.local_id[0], row.track_id[0], row.truncated[0]) == (33, 6, 70, 1)
    assert row.position[0].tolist() == [3, 4, 0]


def test_a_body_is_told_with_the_area_that_is_seen_of_it(reported):
    assert reported(person(fitted=True, visible=0.5)).area[0] == 20


def test_who_is_alone_in_a_whole_blob_is_told_with_his_size(reported, sizes):
    across, upright = sizes.per_metre(person().foot)[0]
    extent = reported(person(), truncated=False).extent
    np.testing.assert_allclose(extent, [[4 / across, 10 / upright]], rtol=1e-6)
    assert np.isnan(reported(person()).extent).all()
    assert np.isnan(reported(person(fitted=True), truncated=False).extent).all()


@pytest.mark.parametrize(('visible', 'colour'), [(0.2, 0.5), (0.9, 0.25)])
def test_of_a_hidden_body_the_colours_are_those_remembered(reported, visible, colour):
    assert (reported(person(fitted=True, visible=visible)).template == colour).all()


@pytest.mark.parametrize(('age_s', 'score'), [(0.0, 0.1), (0.1, 0.5), (1.0, 1.0)])
def test_a_young_track_is_less_certain(reported, age_s, score):
    assert reported(person(), age_s).score[0] == pytest.approx(score)


def test_believed_tracks_are_sighted_whether_seen_or_not(tracks_of):
    tracks = tracks_of(
        mean=np.array([[1.0, 2, 0, 0], [3, 4, 0, 0], [5, 6, 0, 0]]),
        confirmed=np.array([True, True, False]),
        first_ns=np.zeros(3, np.int64),
    )
    tracks = confirmed_tracks(person(), tracks, SECOND_NS)
    assert (tracks.local_id.tolist(), tracks.seen.tolist()) == ([5, 6], [False, True])
    assert (tracks.position.tolist(), tracks.own_share.tolist()) == ([[1, 2], [3, 4]], [0, 1])
    assert (tracks.box[1].tolist(), tracks.age_s.tolist()) == ([10, 20, 4, 10], [1, 1])
