"""Tracks as what RViz and Nav2 know."""

import numpy as np
import pytest

from mctrack_ros.codec import fields_of_cloud
from mctrack_ros.interfaces import Tracks, TrackStatus
from mctrack_ros.ros.topics.markers import marker_array, obstacle_cloud

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
    bodies = [each for each in marker_array(tracks, 'map').markers if each.ns == 'body']
    sizes = [[each.scale.x, each.scale.z] for each in bodies]
    np.testing.assert_allclose(sizes, [CAR, PERSON, PERSON], rtol=1e-6)
    assert [each.pose.position.z * 2 for each in bodies] == [each.scale.z for each in bodies]
