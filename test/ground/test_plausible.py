import numpy as np
import pytest
from lens_cameras import SIZE, camera

from mctrack_ros.ground import CalibrationError, Camera, read_calibration


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
