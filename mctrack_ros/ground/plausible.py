"""Whether a calibration can be true: a camera stands above the ground, sees it, and people."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.camera import CameraMapping
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.projective import ProjectiveMapping

HIGHEST_CAMERA_M = 150.0
PERSON_M = 1.7
SMALLEST_PERSON_PX = 2.0


def check_plausible(mapping: GroundMapping, position: ArrayLike = ()) -> None:
    """
    Refuse a calibration that cannot be true, or whose lengths are not metres.

    A camera stands above the ground, but not more than 150 m, and sees some of it; a person of
    1.7 m is at least 2 px tall at the nearest of its points. Centimetres taken for metres make a
    room's camera 300 m high and its people a hundredth of what they are.

    Parameters
    ----------
    mapping : GroundMapping
        The calibration.
    position : (n, 2) array_like
        Points on the ground that it was made from, m; may be empty.

    Raises
    ------
    CalibrationError
        If it breaks the rule; says what may be meant.

    """
    height = _camera_height(mapping)
    if height < 0:
        raise CalibrationError(
            f'the camera would stand {-height:.2f} m below the ground: are x and y of the ground '
            'swapped, or is its pose the wrong way round?'
        )
    if not np.isfinite(mapping.ground_from_image(_spread(mapping.image_size))).any():
        raise CalibrationError(
            'the camera would see no ground: is its pose that of the optical frame (z forward)?'
        )
    if height > HIGHEST_CAMERA_M:
        raise CalibrationError(
            f'the camera would stand {height:.0f} m above the ground, expected at most '
            f'{HIGHEST_CAMERA_M:.0f} m: are the lengths in centimetres or millimetres?'
        )
    places = np.asarray(position, np.float64).reshape(-1, 2)
    tall = np.abs(mapping.height_px(places, PERSON_M)) if len(places) else np.array([])
    if np.isfinite(tall).any() and np.nanmax(tall) < SMALLEST_PERSON_PX:
        raise CalibrationError(
            f'a person would be at most {np.nanmax(tall):.2g} px tall, expected at least '
            f'{SMALLEST_PERSON_PX:g} px: are the lengths in centimetres or millimetres?'
        )


def _camera_height(mapping: GroundMapping) -> float:
    """Return the camera's height above the ground, m; 0 if the mapping does not know it."""
    if isinstance(mapping, CameraMapping):
        return float(mapping.camera.position[2])
    if isinstance(mapping, ProjectiveMapping):
        return float(mapping.camera_position[2])
    return 0.0


def _spread(image_size: tuple[int, int]) -> NDArray[np.float64]:
    """Return pixels all over a picture, (n, 2)."""
    axes = [np.linspace(0, side, 9) for side in image_size]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
