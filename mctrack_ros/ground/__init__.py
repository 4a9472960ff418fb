"""Between pixels and metres on the ground plane."""

from mctrack_ros.ground.calibration_file import (
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
from mctrack_ros.ground.camera import Camera, CameraMapping
from mctrack_ros.ground.camera_fit import CameraFit, FitError, fit_camera
from mctrack_ros.ground.camera_info import camera_from_info
from mctrack_ros.ground.camera_problem import LensPrior
from mctrack_ros.ground.cells import CellMapping, Cells
from mctrack_ros.ground.check import CalibrationCheck, check_grid, first_look
from mctrack_ros.ground.errors import CalibrationError, GridError, SceneError
from mctrack_ros.ground.grid import TransformationGrid, grid_from_points
from mctrack_ros.ground.grid_checks import grid_flaws
from mctrack_ros.ground.grid_edit import write_fov
from mctrack_ros.ground.grid_file import read_grid, write_grid
from mctrack_ros.ground.heard_camera import HeardCamera
from mctrack_ros.ground.iterated import IteratedMapping
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.methods import METHODS, mapping_from_grid
from mctrack_ros.ground.plausible import check_plausible
from mctrack_ros.ground.projection_file import ProjectionError, read_projection
from mctrack_ros.ground.projective import ProjectiveMapping
from mctrack_ros.ground.scene import read_scene, write_scene
from mctrack_ros.ground.several_cameras import Choice
from mctrack_ros.ground.stored_camera import Pose, StoredCamera, stored_camera
from mctrack_ros.ground.tsai_file import TsaiCalibration, read_tsai

__all__ = [
    'FORMATS',
    'METHODS',
    'METRES',
    'CalibrationCheck',
    'CalibrationError',
    'Camera',
    'CameraFit',
    'CameraMapping',
    'CellMapping',
    'Cells',
    'Choice',
    'FitError',
    'GridError',
    'GroundMapping',
    'HeardCamera',
    'IteratedMapping',
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
