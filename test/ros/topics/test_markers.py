"""Tracks as what RViz and Nav2 know."""

import numpy as np
import pytest
from visualization_msgs.msg import Marker

from mctrack_ros.codec import fields_of_cloud
from mctrack_ros.interfaces import Tracks, TrackStatus
from mctrack_ros.ros.topics.markers import TrackMarkers, obstacle_cloud

CAR, PERSON, UNKNOWN = [4.4, 1.6], [0.5, 1.8], [np.nan, np.nan]


@pytest.fixture
def tracks():
    """Return a car, a person, one of unknown size, and a track that has ended."""
    return Tracks.build(
        0,
        position=[[0, 0, 0], [10, 0, 0], [20, 0, 0], [30, 0, 0]],
        extent=[CAR, PERSON, UNKNOWN, CAR],
        track_id=[1, 2, 3, 4],
        status=[TrackStatus.CONFIRMED] * 3 + [TrackStatus.DELETED],
    )


def test_an_obstacle_is_as_wide_as_its_track_and_no_narrower_than_a_person(tracks):
    fields = fields_of_cloud(obstacle_cloud(tracks, 'map', 0.5))
    points = np.column_stack([fields[axis] for axis in 'xyz']).reshape(3, -1, 3)
    centre = points.mean(axis=1)
    np.testing.assert_allclose(centre, [[0, 0, 0.5], [10, 0, 0.5], [20, 0, 0.5]], atol=1e-5)
    radius = np.linalg.norm(points - centre[:, None], axis=2)
    np.testing.assert_allclose(radius, np.array([[2.2], [0.3], [0.3]]).repeat(12, 1), rtol=1e-4)


def test_a_body_is_as_large_as_its_track_and_stands_on_the_ground(tracks):
    bodies = [each for each in TrackMarkers('map', 5.0).array(tracks).markers if each.ns == 'body']
    sizes = [[each.scale.x, each.scale.z] for each in bodies]
    np.testing.assert_allclose(sizes, [CAR, PERSON, PERSON], rtol=1e-6)
    assert [each.pose.position.z * 2 for each in bodies] == [each.scale.z for each in bodies]


def walked(markers, seconds, track_id=7):
    """Return the markers of the last tick of one who walks along x, by namespace."""
    for index in range(round(seconds / 0.1) + 1):
        tracks = Tracks.build(
            index * 100_000_000,
            position=[[0.1 * index, 2.0, 0.0]],
            covariance=[np.diag([0.09, 0.01, 1.0, 1.0])],
            track_id=[track_id],
        )
        shown = markers.array(tracks).markers
    return {each.ns: each for each in shown}


def test_an_ellipse_holds_95_percent_and_lies_along_its_longer_axis():
    ellipse = walked(TrackMarkers('map', 5.0), 0.0)['covariance']
    assert ellipse.scale.x == pytest.approx(2 * 2.4477 * 0.3, rel=1e-3)
    assert ellipse.scale.y == pytest.approx(2 * 2.4477 * 0.1, rel=1e-3)
    assert abs(ellipse.pose.orientation.z) == pytest.approx(0.0, abs=1e-6) or abs(
        ellipse.pose.orientation.w
    ) == pytest.approx(0.0, abs=1e-6)


def test_a_trail_holds_the_last_seconds():
    points = walked(TrackMarkers('map', 5.0), 20.0)['trail'].points
    assert 24 <= len(points) <= 27
    assert points[0].x == pytest.approx(15.0, abs=0.3)
    assert points[-1].x == pytest.approx(20.0, abs=0.3)


def test_markers_of_who_is_gone_are_deleted_and_all_when_time_begins_anew():
    markers = TrackMarkers('map', 5.0)
    walked(markers, 10.0)
    gone = markers.array(Tracks.build(11_000_000_000)).markers
    assert {each.action for each in gone} == {Marker.DELETE}
    assert {each.ns for each in gone} == {'body', 'name', 'covariance', 'trail'}
    assert {each.id for each in gone} == {7}
    assert markers.array(Tracks.build(11_100_000_000)).markers == []
    (anew,) = markers.array(Tracks.build(0)).markers
    assert anew.action == Marker.DELETEALL
