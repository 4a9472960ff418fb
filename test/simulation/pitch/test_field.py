import numpy as np
import pytest

from mctrack_ros.simulation import CameraRenderer, landmarks
from mctrack_ros.simulation.pitch.field import beyond_edge, line_distance

ON_A_LINE = [(0, 10), (105, 34), (50, 0), (52.5, 20), (16.5, 30), (88.5, 40), (61.65, 34)]
OFF_LINES = [((52.5 + 5, 34), 4.15), ((3, 34), 2.5), ((30, 4), 4.0), ((-2, 30), 2.0)]


def test_painted_lines_are_at_no_distance():
    places = np.array([*ON_A_LINE, *landmarks().values()], float)
    np.testing.assert_allclose(line_distance(places[:, 0], places[:, 1]), 0, atol=1e-9)


@pytest.mark.parametrize(('place', 'distance'), OFF_LINES)
def test_distance_to_the_nearest_line(place, distance):
    x, y = np.array(place)[:, None]
    assert line_distance(x, y)[0] == pytest.approx(distance)


def test_only_places_outside_are_beyond_the_edge():
    outside = beyond_edge(np.array([0.0, 50, -3, 108]), np.array([0.0, 34, -4, 34]))
    np.testing.assert_allclose(outside, [0, 0, 5, 3])


@pytest.mark.parametrize('distortion', [0.0, -0.3])
def test_lines_are_painted_where_the_camera_projects_them(staged, distortion):
    world = staged({}, distortion=distortion)
    image, _ = CameraRenderer(world, 4).frame(0)
    along = np.linspace(2, 66, 33)
    halfway = np.column_stack([np.full(33, 52.5), along, np.zeros(33)])
    beside = halfway + np.array([1.0, 0, 0])
    column, row = np.floor(world.cameras[4].project(halfway)).astype(int).T
    other_column, other_row = np.floor(world.cameras[4].project(beside)).astype(int).T
    brighter = image[row, column].mean(axis=1) - image[other_row, other_column].mean(axis=1)
    assert (brighter > 20).mean() > 0.9
