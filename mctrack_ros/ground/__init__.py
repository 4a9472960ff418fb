"""Between pixels and metres on the ground plane."""

from mctrack_ros.ground.grid import GridError, TransformationGrid, read_grid, write_grid
from mctrack_ros.ground.projective import ProjectiveMapping

__all__ = ['GridError', 'ProjectiveMapping', 'TransformationGrid', 'read_grid', 'write_grid']
