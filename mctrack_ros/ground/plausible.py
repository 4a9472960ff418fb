"""Whether a calibration can be true: a camera stands above the ground, sees it, and people."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.camera.pinhole import CameraMapping
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import GroundMapping

Floats = NDArray[np.float64]
LOWEST_CAMERA_M, HIGHEST_CAMERA_M = 0.3, 150.0
PERSON_M = 1.75
SMALLEST_PERSON_PX = 2.0
SMALLEST_PERSON, TALLEST_PERSON = 0.01, 2.0
"""How large a person in the middle is at least and at most, in images: centimetres taken for
metres make one who fills the image a hundredth of it."""
_TOO_LONG = {'feet': 0.3048, 'centimetres': 0.01, 'millimetres': 0.001}
_TOO_SHORT = {
    'metres that were taken for centimetres': 100.0,
    'metres that were taken for millimetres': 1000.0,
}


def check_plausible(mapping: GroundMapping, position: ArrayLike = ()) -> None:
    """
    Refuse a calibration that cannot be true, or whose lengths are not metres.

    A camera stands 0.3 to 150 m above the ground and sees some of it, its points not mirrored (a
    bare matrix may lead to a plan whose y runs down); a person of 1.75 m in the middle of its
    points, as the image shows them, is at least 2 px and a hundredth of the image's height
    large (lying, where the camera looks down), and at most twice that height; without points,
    where it is nearest and in the middle of the image. Centimetres taken for metres make a
    room's camera 300 m high and its people a hundredth of what they are.

    Parameters
    ----------
    mapping : GroundMapping
        The calibration; knows where its camera stands, or nothing is said of that.
    position : (n, 2) array_like
        Points on the ground that it was made from, m; may be empty.

    Raises
    ------
    CalibrationError
        If it breaks the rule; says what may be meant.

    """
    height = _camera_height(mapping)
    if height is not None and height < 0:
        raise CalibrationError(
            f'the camera would stand {-height:.2f} m below the ground: are x and y of the ground '
            'swapped, or is its pose the wrong way round?'
        )
    seen = mapping.ground_from_image(_spread(mapping.image_size))
    seen = seen[np.isfinite(seen).all(axis=1)]
    if not len(seen):
        raise CalibrationError(
            'the camera would see no ground: is its pose that of the optical frame (z forward)?'
        )
    _check_height(height)
    shown = mapping.image_from_ground(np.asarray(position, np.float64).reshape(-1, 2))
    shown = shown[np.isfinite(shown).all(axis=1)]
    centre = shown.mean(axis=0) if len(shown) else np.array(mapping.image_size) / 2
    middle = mapping.ground_from_image(centre)
    if len(shown) and np.linalg.det(mapping.image_jacobian(middle)[0]) > 0:
        raise CalibrationError(
            'the ground would be mirrored: seen from above, y lies to the left of x; is the sign '
            'of one axis wrong, or are x and y swapped?'
        )
    _check_person(mapping, middle if len(shown) else seen, middle, height)


def _check_height(height: float | None) -> None:
    if height is not None and height > HIGHEST_CAMERA_M:
        raise CalibrationError(
            f'the camera would stand {height:.0f} m above the ground, expected at most '
            f'{HIGHEST_CAMERA_M:.0f} m{_meant(height, _TOO_LONG)}'
        )
    if height is not None and height < LOWEST_CAMERA_M:
        raise CalibrationError(
            f'the camera would stand {height:.2g} m above the ground, expected at least '
            f'{LOWEST_CAMERA_M:g} m{_meant(height, _TOO_SHORT)}'
        )


def _check_person(
    mapping: GroundMapping, near: Floats, middle: Floats, height: float | None
) -> None:
    """Refuse what leaves a person tiny wherever it is near, or makes it a giant in the middle."""
    rows = mapping.image_size[1]
    large = np.fmax(np.abs(mapping.height_px(near, PERSON_M)), mapping.width_px(near, PERSON_M))
    large, least = large[np.isfinite(large)], max(SMALLEST_PERSON_PX, SMALLEST_PERSON * rows)
    if len(large) and large.max() < least:
        raise CalibrationError(
            f'a person would be {large.max():.2g} px large, expected at least {least:.2g} px'
            f'{_meant(height, _TOO_LONG)}'
        )
    tall = float(np.abs(mapping.height_px(middle, PERSON_M))[0])
    behind = bool(np.isnan(tall) and np.isfinite(mapping.image_from_ground(middle)).all())
    if behind or tall > TALLEST_PERSON * rows:
        what = 'rise behind the camera' if behind else f'be {tall:.0f} px tall'
        raise CalibrationError(
            f'a person in the middle would {what}, expected at most {TALLEST_PERSON * rows:.0f} px'
            f'{_meant(height, _TOO_SHORT)}'
        )


def _meant(height: float | None, units: Mapping[str, float]) -> str:
    """Return a question after the units in which the camera would be at a height that can be."""
    meant = [
        f'{unit} (the camera is {height * metres:.2g} m up then)'
        for unit, metres in units.items()
        if height is not None and LOWEST_CAMERA_M <= height * metres <= HIGHEST_CAMERA_M
    ]
    return f': are the lengths {" or ".join(meant)}?' if meant else ''


def _camera_height(mapping: GroundMapping) -> float | None:
    """Return the camera's height above the ground, m; None if the mapping does not know it."""
    if isinstance(mapping, CameraMapping | ProjectiveMapping):
        return float(mapping.camera_position[2])
    return None


def _spread(image_size: tuple[int, int]) -> NDArray[np.float64]:
    """Return pixels all over an image, (n, 2)."""
    axes = [np.linspace(0, side, 9) for side in image_size]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
