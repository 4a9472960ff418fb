import dataclasses

import numpy as np
import pytest

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import (
    METHODS,
    CalibrationError,
    Camera,
    CameraMapping,
    GridError,
    ProjectiveMapping,
    grid_from_points,
    mapping_from_grid,
    read_calibration,
    read_grid,
    write_calibration,
    write_grid,
)
from mctrack_ros.ground.plausible import check_plausible


def test_a_matrix_of_a_camera_below_the_ground_is_refused(tmp_path):
    matrix = camera().camera.image_from_world @ np.diag([1, 1, -1, 1.0])
    path = tmp_path / 'matrix.yaml'
    path.write_text(f'image_from_world: {matrix.tolist()}')
    with pytest.raises(CalibrationError, match='below the ground'):
        read_calibration(path, SIZE)


def test_a_mirrored_rotation_is_refused():
    inner = camera().camera
    with pytest.raises(ValueError, match='reflection'):
        Camera(
            inner.intrinsics, inner.distortion, np.diag([-1, 1, 1]) @ inner.rotation,
            inner.translation,
        )  # fmt: skip


def grid_of(mapping, spacing=4.0, unit=1.0):
    """Return what a camera sees of a square grid; lengths are multiplied by the unit."""
    ground = seen_grid(mapping, spacing, 24.0)
    names = [f'{x:g}:{y:g}' for x, y in ground]
    return grid_from_points('cam', names, ground * unit, mapping.image_from_ground(ground))[0]


@pytest.mark.parametrize('flip', [(1, -1), (-1, 1)])
@pytest.mark.parametrize('method', METHODS)
def test_a_mirrored_grid_is_refused_by_every_method_and_where_it_is_read(tmp_path, method, flip):
    grid = grid_of(camera())
    mirrored = dataclasses.replace(grid, ground=grid.ground * flip)
    with pytest.raises(CalibrationError, match=r'mirrored|swapped'):
        mapping_from_grid(mirrored, SIZE, method)
    write_grid(mirrored, tmp_path / 'grid.xml')
    with pytest.raises(GridError, match=r'grid.xml:3: the ground is mirrored'):
        read_grid(tmp_path / 'grid.xml')


def test_a_mirrored_world_is_refused_but_a_plan_may_have_its_y_downwards(tmp_path):
    matrix = camera().camera.image_from_world * (1, -1, 1, 1)
    path = tmp_path / 'matrix.yaml'
    path.write_text(f'image_from_world: {matrix.tolist()}')
    with pytest.raises(CalibrationError, match='world would be mirrored'):
        read_calibration(path, SIZE)
    path.write_text(f'image_from_ground: {matrix[:, [0, 1, 3]].tolist()}')
    read_calibration(path, SIZE)


ROOM = camera(eye=(0.5, -3.0, 1.2), target=(0.0, 2.0, 0.0))


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize(
    ('unit', 'reason'),
    [
        (100.0, 'px large.*are the lengths .*centimetres .the camera is 1.2 m up then'),
        (1000.0, 'm above the ground.*are the lengths .*millimetres .the camera is 1.2 m up'),
        (0.01, '0.012 m above the ground.*are the lengths metres that were taken for centi'),
    ],
)
def test_a_room_in_another_unit_is_refused_and_the_unit_is_named(method, unit, reason):
    room = grid_of(ROOM, 0.5)
    mapping_from_grid(room, SIZE, method)
    with pytest.raises(CalibrationError, match=reason):
        mapping_from_grid(dataclasses.replace(room, ground=room.ground * unit), SIZE, method)


@pytest.mark.parametrize('to', ['opencv', 'camera_info'])
def test_metres_that_are_said_to_be_centimetres_are_refused(tmp_path, to):
    path = tmp_path / 'camera.yaml'
    write_calibration(camera(), path, to, 'cam')
    with pytest.raises(CalibrationError, match=r'0\.15 m above .*metres that were taken'):
        read_calibration(path, SIZE, unit='cm')


def test_a_giant_is_refused():
    yard = camera(eye=(3.0, -30.0, 45.0), target=(0.0, 0.0, 0.0)).camera
    small = CameraMapping(dataclasses.replace(yard, translation=yard.translation / 100), SIZE)
    with pytest.raises(
        CalibrationError,
        match=r'behind the camera.*: are the lengths metres',
    ):
        check_plausible(small)


@pytest.mark.parametrize('tilt', [0.0, 1.0, 30.0])
def test_a_camera_that_looks_at_the_horizon_is_accepted(tilt):
    mapping = camera(eye=(0, 0, 8.0), target=(0, 10.0, 8.0 - 10.0 * np.tan(np.radians(tilt))))
    check_plausible(mapping)
    check_plausible(ProjectiveMapping(mapping.camera.image_from_world, SIZE))


@pytest.mark.parametrize('method', METHODS)
def test_a_camera_that_looks_straight_down_from_high_up_is_accepted(tmp_path, method):
    """People are seen from above: hardly taller than nothing, yet not small."""
    above = camera(eye=(0.0, -1.0, 35.0), target=(0.0, 0.0, 0.0), focal=600.0)
    check_plausible(above)
    mapping_from_grid(grid_of(above), SIZE, method)


@pytest.mark.parametrize('to', ['grid', 'opencv'])
def test_a_camera_that_sees_far_is_accepted(tmp_path, to):
    """Most points of its grid lie far away, and still in the middle of the image."""
    pitch = camera(eye=(52.5, -20.0, 35.0), target=(52.5, 34.0, 0.0), focal=600.0)
    path = tmp_path / 'pitch.xml'
    write_calibration(pitch, path, to, 'pitch')
    read_calibration(path, SIZE)
