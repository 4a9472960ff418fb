import numpy as np
import pytest

from mctrack_ros.perception.silhouettes.ground_position import PlaceConfig, Places


@pytest.fixture(scope='module')
def places(mapping):
    return Places(PlaceConfig(), 1.5, mapping)


def boxed(mapping, points):
    """Return the box, px, about (n, 3) points, m."""
    points = np.asarray(points, float)
    pixel = mapping.image_from_ground(points[:, :2], points[:, 2])
    low, high = pixel.min(axis=0), pixel.max(axis=0)
    return np.concatenate([low, high - low])[None]


def test_a_person_stands_at_the_feet(mapping, places):
    box = boxed(mapping, [(x, 1.0, z) for x in (1.75, 2.25) for z in (0, 1.75)])
    position, covariance = places.locate(box, np.array([False]))
    assert np.allclose(position, [[2.0, 1.0]], atol=0.15)
    assert (np.linalg.eigvalsh(covariance[0]) > 0).all()
    assert np.allclose(places.extent(box), [[0.5, 1.75]], rtol=0.15)


def test_a_vehicle_stands_in_the_middle_of_the_ground_that_it_covers(mapping, places):
    corners = [(x, y, z) for x in (-0.9, 0.9) for y in (0, 4.2) for z in (0, 1.5)]
    position, covariance = places.locate(boxed(mapping, corners), np.array([True]))
    assert np.allclose(position, [[0.0, 2.1]], atol=0.35)
    assert np.sqrt(covariance[0, 1, 1]) > 1.0


def test_a_moved_camera_is_less_certain(mapping, places):
    box = boxed(mapping, [(x, 1.0, z) for x in (1.75, 2.25) for z in (0, 1.75)])
    still, moved = (places.locate(box, np.array([False]), shift)[1] for shift in (0.0, 5.0))
    assert np.trace(moved[0]) > np.trace(still[0])
