import numpy as np

from mctrack_ros.perception.geometry.person_size import SizeTable

PLACES = np.array([[0.0, 0.0], [-4.0, 2.0], [5.0, -1.0], [2.0, 6.0]])


def test_table_agrees_with_the_mapping(mapping):
    sizes = SizeTable(mapping).per_metre(mapping.image_from_ground(PLACES))
    assert np.allclose(sizes[:, 0], mapping.width_px(PLACES, 1.0), rtol=0.04)
    assert np.allclose(sizes[:, 1], mapping.height_px(PLACES, 1.0), rtol=0.04)


def test_foot_of_a_box_undoes_box_of_a_foot(mapping):
    sizes = SizeTable(mapping)
    foot = mapping.image_from_ground(PLACES)
    box = sizes.box_of(foot, np.full((4, 2), [0.6, 1.8]))
    assert np.allclose(sizes.foot_of(box), foot, atol=0.25)


def test_box_is_centred_between_head_and_foot(mapping):
    sizes = SizeTable(mapping)
    foot, head = mapping.image_from_ground(PLACES), mapping.image_from_ground(PLACES, 1.8)
    box = sizes.box_of(foot, np.full((4, 2), [0.6, 1.8]))
    assert np.allclose(box[:, 0] + box[:, 2] / 2, (foot[:, 0] + head[:, 0]) / 2, atol=0.7)
