"""A transformation grid for a camera that is calibrated otherwise: points put where it sees."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.errors import CalibrationError, GridError
from mctrack_ros.ground.grid import TransformationGrid, grid_from_points
from mctrack_ros.ground.lens import picture_samples
from mctrack_ros.ground.mapping import GroundMapping

Floats = NDArray[np.float64]
SPACINGS_M = (20.0, 10.0, 8.0, 5.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)
FEWEST_CELLS = 12
MOST_SIDE = 200
PERSON_M = 1.7
SMALLEST_SHARE = 0.2
"""Points lie where a person is at least so tall, as a share of the tallest in the picture."""


def sampled_grid(mapping: GroundMapping, name: str) -> TransformationGrid:
    """
    Return a square grid with the widest round spacing that gives a dozen cells in the picture.

    Parameters
    ----------
    mapping : GroundMapping
        The calibration.
    name : str
        Of the camera.

    Raises
    ------
    CalibrationError
        If the picture shows too little ground.

    """
    pixel = picture_samples(mapping.image_size)
    pixel = pixel[~mapping.is_extrapolated(pixel)]
    ground = mapping.ground_from_image(pixel)
    ground = ground[np.isfinite(ground).all(axis=1)]
    if len(ground) == 0:
        raise CalibrationError(f'{name} sees no ground')
    tall = np.abs(mapping.height_px(ground, PERSON_M))
    tall = np.where(np.isfinite(tall), tall, 0.0)
    near = ground[tall >= SMALLEST_SHARE * tall.max()]
    low, high = near.min(axis=0), near.max(axis=0)
    for spacing in SPACINGS_M:
        first, last = np.ceil(low / spacing), np.floor(high / spacing)
        if (last - first < 2).any() or (last - first > MOST_SIDE).any():
            continue
        axes = [np.arange(a, b + 1) for a, b in zip(first, last)]
        index = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2).astype(np.int64)
        grid = _seen(mapping, name, index, spacing)
        if grid is not None and len(grid.names) >= FEWEST_CELLS:
            return grid
    raise CalibrationError(f'{name} sees too little ground for a grid of {FEWEST_CELLS} cells')


def _seen(
    mapping: GroundMapping, name: str, index: NDArray[np.int64], spacing: float
) -> TransformationGrid | None:
    ground = np.round(index * spacing, 6)
    image = mapping.image_from_ground(ground)
    back = mapping.ground_from_image(image)
    with np.errstate(invalid='ignore'):
        seen = ((image >= 0) & (image <= mapping.image_size)).all(axis=1)
        seen &= (np.abs(back - ground) < 1e-3 * spacing).all(axis=1)
    names = [f'{x}:{y}' for x, y in index[seen].tolist()]
    try:
        grid, _ = grid_from_points(name, names, ground[seen], image[seen])
    except GridError:
        return None
    return dataclasses.replace(grid, image_size=mapping.image_size)
