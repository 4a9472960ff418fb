"""Between pixels and metres on the ground plane."""

from mctrack_ros.ground.camera import Camera, CameraMapping
from mctrack_ros.ground.camera_fit import CameraFit, FitError, fit_camera
from mctrack_ros.ground.cells import CellMapping, Cells
from mctrack_ros.ground.grid import (
    GridError,
    TransformationGrid,
    grid_from_points,
    read_grid,
    write_grid,
)
from mctrack_ros.ground.iterated import IteratedMapping
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.methods import METHODS, mapping_from_grid
from mctrack_ros.ground.projection_file import ProjectionError, read_projection
from mctrack_ros.ground.projective import ProjectiveMapping

__all__ = [
    'METHODS',
    'Camera',
    'CameraFit',
    'CameraMapping',
    'CellMapping',
    'Cells',
    'FitError',
    'GridError',
    'GroundMapping',
    'IteratedMapping',
    'ProjectionError',
    'ProjectiveMapping',
    'TransformationGrid',
    'fit_camera',
    'grid_from_points',
    'mapping_from_grid',
    'read_grid',
    'read_projection',
    'write_grid',
]
