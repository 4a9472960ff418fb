"""Cameras as Kalibr stores them: a chain of them in one YAML."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mctrack_ros.ground.camera.stored import StoredCamera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.keys import KALIBR
from mctrack_ros.ground.files.keyed.lens_models import MIRRORS, lens_model, lens_of, mirror_lens
from mctrack_ros.ground.files.keyed.stated import Stated, whole
from mctrack_ros.ground.files.several_cameras import ANY, Choice

_KEY = re.compile(r'cam\d+')
SHAPES = {'pinhole': 0, 'omni': 1, 'ds': 2, 'eucm': 2}
"""How many numbers stand before fu, fv, pu, pv in a camera's intrinsics."""
LENSES = {
    'pinhole': {'none': 0, 'plumb_bob': 4, 'equidistant': 4, 'fov': 1},
    'omni': {'none': 0, 'plumb_bob': 4},
    'ds': {'none': 0},
    'eucm': {'none': 0},
}
"""Which lenses stand behind each kind of camera, and their terms; plumb_bob is its radtan."""


_SPELLED = {
    'camera': 'camera_model',
    'intrinsics': 'intrinsics',
    'model': 'distortion_model',
    'lens': 'distortion_coeffs',
    'size': 'resolution',
}


def kalibr_cameras(values: Mapping[Any, Any]) -> dict[str, Mapping[Any, Any]]:
    """Return the cameras of a chain by their keys; empty: it is none."""
    return {
        str(key): value
        for key, value in values.items()
        if _KEY.fullmatch(str(key)) and isinstance(value, Mapping) and 'intrinsics' in value
    }


def read_kalibr(
    values: Mapping[Any, Any], where: str | Path, choice: Choice = ANY
) -> StoredCamera:
    """
    Return one camera of a chain; where it stands on the ground the file does not say.

    Parameters
    ----------
    values : mapping
        What the file holds.
    where : str or Path
        The file, to name.
    choice : Choice
        Which camera.

    Raises
    ------
    CalibrationError
        If it could be one of several cameras, or is of an unknown kind.

    """
    cameras = kalibr_cameras(values)
    topics = {key: str(value.get('rostopic', '')) for key, value in cameras.items()}
    key = choice.of(topics, where)
    stated = Stated(cameras[key], f'{where}: {key}', KALIBR)
    for needed in ('camera', 'intrinsics', 'model', 'lens', 'size'):
        if needed not in stated:
            raise stated.error(f'no {_SPELLED[needed]}')
    kind = str(stated.value('camera'))
    if kind not in SHAPES:
        raise stated.error(f'camera_model is {kind!r}, expected one of {sorted(SHAPES)}')
    numbers = stated.numbers('intrinsics', 4 + SHAPES[kind])
    width, height = (whole(side, 'resolution') for side in stated.numbers('size', 2).tolist())
    shape, intrinsics = numbers[:-4], numbers[-4:]
    if min(intrinsics[:2]) <= 0 or min(width, height) <= 0:
        raise stated.error('focal lengths and resolution are expected above 0')
    size, model = (width, height), _model(stated, kind)
    terms = stated.numbers('lens', LENSES[kind][model])
    try:
        if kind in MIRRORS:
            lens = mirror_lens(kind, tuple(shape.tolist()), intrinsics, terms, size)
        else:
            lens = lens_of(model, intrinsics, terms, size)
    except CalibrationError as error:
        raise stated.error(str(error)) from error
    return StoredCamera(lens[0], lens[1], None, size, lens[2])


def _model(stated: Stated, kind: str) -> str:
    """Return the lens behind a kind of camera, one of `lens_models.TERMS`."""
    called = stated.value('model')
    try:
        model = lens_model(called)
    except CalibrationError as error:
        raise stated.error(str(error)) from error
    if model not in LENSES[kind]:
        raise stated.error(f'{kind} with {called}, expected {" or ".join(LENSES[kind])}')
    return model
