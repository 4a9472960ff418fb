"""Chains of transforms against products of matrices, and what TF can get wrong."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from mctrack_ros.ground import CalibrationError
from mctrack_ros.ground.files.transforms import TransformTree
from ros_cameras import DOWN_TURN, HOUSE, HOUSE_TURN, POLE, house_place, transforms

kinds = get_typestore(Stores.ROS2_JAZZY).types.__getitem__
HOUSE_CHAIN = (
    ('map', 'house', HOUSE, HOUSE_TURN),
    ('house', 'north_optical_frame', POLE, DOWN_TURN),
)


UPRIGHT = (0, 0, 0, 1)


def heard(*each):
    tree = TransformTree()
    for one in each:
        tree.hear(transforms(kinds, one))
    return tree


def test_a_chain_puts_the_camera_where_its_last_frame_is():
    pose = heard(*HOUSE_CHAIN).pose('map', 'north_optical_frame')
    place = -pose.rotation.T @ pose.translation
    np.testing.assert_allclose(place, house_place(POLE), atol=1e-12)
    ahead = pose.rotation.T @ [0, 0, 1]
    np.testing.assert_allclose(ahead, [-0.784600, 0, -0.62], atol=1e-5)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 100), min_size=2, max_size=7), st.integers(0, 2**31))
def test_any_two_frames_of_a_tree_join_in_either_direction(above, seed):
    rng = np.random.default_rng(seed)
    up, each = [np.eye(4)], []
    for child, choice in enumerate(above, 1):
        parent = choice % child
        shift, turn = rng.normal(0, 5, 3), Rotation.random(random_state=rng)
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = turn.as_matrix(), shift
        up.append(up[parent] @ step)
        each.append((f'f{parent}', f'f{child}', shift, turn.as_quat()))
    tree = heard(*(each[index] for index in rng.permutation(len(each))))
    ground, optical = rng.integers(0, len(up), 2)
    pose = tree.pose(f'f{ground}', f'f{optical}')
    expected = np.linalg.inv(up[optical]) @ up[ground]
    np.testing.assert_allclose(pose.rotation, expected[:3, :3], atol=1e-9)
    np.testing.assert_allclose(pose.translation, expected[:3, 3], atol=1e-8)


def test_the_newest_transform_of_a_frame_counts_and_slashes_do_not():
    tree = heard(('map', 'cam', (9, 9, 9), UPRIGHT), ('/map', '/cam', (1, 2, 3), UPRIGHT))
    np.testing.assert_allclose(tree.pose('map', 'cam').translation, [-1, -2, -3])
    assert tree.frames == ('cam', 'map')


def test_frames_that_nothing_joins_have_no_pose():
    tree = heard(HOUSE_CHAIN[1], ('map', 'odom', (0, 0, 0), UPRIGHT))
    assert tree.pose('map', 'north_optical_frame') is None
    assert tree.pose('map', 'nobody') is None


def test_what_cannot_be_a_transform_is_named_and_only_where_it_is_needed():
    tree = heard(*HOUSE_CHAIN, ('map', 'robot', (0, 0, 0), (0, 0, 0, 0)))
    tree.pose('map', 'north_optical_frame')
    with pytest.raises(CalibrationError, match='transform map -> robot: the quaternion'):
        tree.pose('map', 'robot')
    circle = heard(('a', 'b', (0, 0, 0), UPRIGHT), ('b', 'a', (0, 0, 0), UPRIGHT))
    with pytest.raises(CalibrationError, match='circle: a -> b -> a'):
        circle.pose('a', 'b')
