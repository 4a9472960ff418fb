"""From a transformation grid to a mapping, by the name of a method."""

from __future__ import annotations

from mctrack_ros.ground.camera.fit import FitError, fit_camera
from mctrack_ros.ground.camera.pinhole import CameraMapping
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.plausible import check_plausible

METHODS = ('fitted', 'cell', 'iterated', 'homography')
"""A camera fitted to the points; a homography a cell; the paper's; one homography for all."""


def mapping_from_grid(
    grid: TransformationGrid,
    image_size: tuple[int, int],
    method: str = 'fitted',
    click_noise_px: float = 0.5,
) -> GroundMapping:
    """
    Return the mapping that a grid gives.

    Parameters
    ----------
    grid : TransformationGrid
        Cells with their points.
    image_size : (int, int)
        Width and height of the images, px.
    method : str
        One of `METHODS`.
    click_noise_px : float
        Standard deviation of a click along one axis, px.

    Raises
    ------
    CalibrationError, ValueError
        If the grid does not give one, is for images of another size, or not in metres.

    """
    grid.check_size(image_size)
    mapping = _mapping(grid, image_size, method, click_noise_px)
    knows_height = isinstance(mapping, CameraMapping | ProjectiveMapping)
    upright = (
        mapping if knows_height else ProjectiveMapping.from_points(*grid.points(), image_size)
    )
    check_plausible(upright, grid.ground)
    return mapping


def _mapping(
    grid: TransformationGrid, image_size: tuple[int, int], method: str, click_noise_px: float
) -> GroundMapping:
    if method == 'cell':  # imported when chosen: their loops are compiled on import
        from mctrack_ros.ground.grid.cells import CellMapping, Cells

        return CellMapping(Cells.of(grid), image_size, click_noise_px)
    if method == 'iterated':
        from mctrack_ros.ground.grid.cells import Cells
        from mctrack_ros.ground.grid.iterated import IteratedMapping

        return IteratedMapping(Cells.of(grid), image_size, click_noise_px=click_noise_px)
    ground, image = grid.points()
    if method == 'homography':
        return ProjectiveMapping.from_points(ground, image, image_size, click_noise_px)
    try:
        return fit_camera(ground, image, image_size, click_noise_px).mapping
    except FitError as error:
        raise FitError(f'{error}; or map by `method: homography`') from error
