"""A transformation grid for a camera that is calibrated otherwise: points put where it sees."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.camera.lens import image_samples
from mctrack_ros.ground.errors import CalibrationError, GridError
from mctrack_ros.ground.grid.methods import mapping_from_grid
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid, grid_from_points
from mctrack_ros.ground.mapping import GroundMapping

Floats = NDArray[np.float64]
SPACINGS_M = (20.0, 10.0, 8.0, 5.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)
FEWEST_CELLS = 12
MOST_SIDE = 200
PERSON_M = 1.7
REACH_M = 200.0
"""How far from the camera a grid has to reproduce what it was sampled from."""
SMALLEST_SHARE = 0.2
"""Points lie where a person is at least so tall, as a share of the tallest in the image."""


def sampled_grid(mapping: GroundMapping, name: str) -> TransformationGrid:
    """
    Return a square grid with the widest round spacing that gives a dozen cells in the image.

    Parameters
    ----------
    mapping : GroundMapping
        The calibration.
    name : str
        Of the camera.

    Raises
    ------
    CalibrationError
        If the image shows too little ground.

    """
    pixel = image_samples(mapping.image_size)
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


def grid_miss_px(mapping: GroundMapping, grid: TransformationGrid) -> float:
    """
    Return how far at most the camera fitted to a grid is from a mapping, px.

    Over the image, as far as the mapping is supported and sees the ground, at a person's feet
    and head.

    Parameters
    ----------
    mapping : GroundMapping
        What the grid was sampled from.
    grid : TransformationGrid
        The grid.

    Raises
    ------
    CalibrationError
        If no camera can be fitted to the grid.

    """
    fitted = mapping_from_grid(grid, mapping.image_size)
    pixel = image_samples(mapping.image_size)
    ground = mapping.ground_from_image(pixel[~mapping.is_extrapolated(pixel)])
    ground = ground[(np.linalg.norm(ground - mapping.camera_position[:2], axis=1) < REACH_M)]
    missed = [
        np.linalg.norm(fitted.image_from_ground(ground, z) - mapping.image_from_ground(ground, z),
                       axis=1)
        for z in (0.0, PERSON_M)
    ]  # fmt: skip
    return float(np.nan_to_num(missed, nan=np.inf).max())


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
