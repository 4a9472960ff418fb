"""Between pixels and metres on the ground plane."""

from mctrack_ros.ground.camera.fit import CameraFit, FitError, fit_camera
from mctrack_ros.ground.camera.fit_problem import LensPrior
from mctrack_ros.ground.camera.pinhole import Camera, CameraMapping
from mctrack_ros.ground.camera.stored import Pose, StoredCamera, stored_camera
from mctrack_ros.ground.errors import CalibrationError, GridError, SceneError
from mctrack_ros.ground.files.calibration_file import (
    FORMATS,
    METRES,
    camera_mapping,
    file_format,
    holds_camera,
    knows_its_error,
    read_calibration,
    read_camera,
    read_extrinsics,
    stated_size,
    write_calibration,
)
from mctrack_ros.ground.files.camera_info import camera_from_info
from mctrack_ros.ground.files.heard_camera import HeardCamera
from mctrack_ros.ground.files.projection import ProjectionError, read_projection
from mctrack_ros.ground.files.several_cameras import Choice
from mctrack_ros.ground.files.tsai import TsaiCalibration, read_tsai
from mctrack_ros.ground.grid.calibration_check import CalibrationCheck, check_grid, first_look
from mctrack_ros.ground.grid.checks import grid_flaws
from mctrack_ros.ground.grid.edit import write_fov
from mctrack_ros.ground.grid.file import read_grid, write_grid
from mctrack_ros.ground.grid.methods import METHODS, mapping_from_grid
from mctrack_ros.ground.grid.scene import read_scene, write_scene
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid, grid_from_points
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.plausible import check_plausible

__all__ = [
    'FORMATS',
    'METHODS',
    'METRES',
    'CalibrationCheck',
    'CalibrationError',
    'Camera',
    'CameraFit',
    'CameraMapping',
    'Choice',
    'FitError',
    'GridError',
    'GroundMapping',
    'HeardCamera',
    'LensPrior',
    'Pose',
    'ProjectionError',
    'ProjectiveMapping',
    'SceneError',
    'StoredCamera',
    'TransformationGrid',
    'TsaiCalibration',
    'camera_from_info',
    'camera_mapping',
    'check_grid',
    'check_plausible',
    'file_format',
    'first_look',
    'fit_camera',
    'grid_flaws',
    'grid_from_points',
    'holds_camera',
    'knows_its_error',
    'mapping_from_grid',
    'read_calibration',
    'read_camera',
    'read_extrinsics',
    'read_grid',
    'read_projection',
    'read_scene',
    'read_tsai',
    'stated_size',
    'stored_camera',
    'write_calibration',
    'write_fov',
    'write_grid',
    'write_scene',
]
