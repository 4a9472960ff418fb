"""Between pixels and metres on the ground plane."""

from mctrack_ros.ground.grid import GridError, TransformationGrid, read_grid, write_grid
from mctrack_ros.ground.projection_file import ProjectionError, read_projection
from mctrack_ros.ground.projective import ProjectiveMapping

__all__ = [
    'GridError',
    'ProjectionError',
    'ProjectiveMapping',
    'TransformationGrid',
    'read_grid',
    'read_projection',
    'write_grid',
]
