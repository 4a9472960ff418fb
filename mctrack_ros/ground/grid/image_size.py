"""For images of which size points were clicked, where the grid does not say."""

from __future__ import annotations

from mctrack_ros.ground.camera.fit import CameraFit, fit_camera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid

SHARES = (1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 4 / 3, 3 / 2, 2, 3, 4)
BETTER = 0.5
"""A size is suggested if its residual is at most this share: .5 is twice as close."""


def size_hint(
    grid: TransformationGrid, image_size: tuple[int, int], rms_px: float, most_px: float
) -> str:
    """
    Return what to ask of a grid that does not fit its images: whether they were scaled.

    A camera's axis goes nearly through the middle of its image, so points of a smaller or larger
    one do not fit, or make the camera unusual.

    Parameters
    ----------
    grid : TransformationGrid
        The points.
    image_size : (int, int)
        Width and height of the images that they do not fit, px.
    rms_px : float
        How far they miss, px; infinite: they give no camera, or an unusual one.
    most_px : float
        How far they may miss in another size, px.

    Returns
    -------
    str
        Begins with a semicolon; empty: no other size fits, or the grid states its own.

    """
    if grid.image_size is not None:
        return ''
    sizes = [(round(image_size[0] * share), round(image_size[1] * share)) for share in SHARES]
    missed = {size: _missed_px(grid, size) for size in sizes}
    best = min(missed, key=lambda size: missed[size])
    if not missed[best] <= min(BETTER * rms_px, most_px):
        return ''
    return (
        f'; they fit images of {best[0]} x {best[1]} px: is the image size '
        f'{image_size[0]} x {image_size[1]} px wrong for this grid?'
    )


def _missed_px(grid: TransformationGrid, size: tuple[int, int]) -> float:
    """Return how far the points miss for images of a size; infinite: they give no camera."""
    try:
        grid.check_size(size)
        return closeness_px(fit_camera(*grid.points(), size))
    except CalibrationError:
        return float('inf')


def closeness_px(fit: CameraFit) -> float:
    """Return how far a camera misses its points, px; infinite: its lens is unusual."""
    return float('inf') if fit.oddity else fit.rms_px
