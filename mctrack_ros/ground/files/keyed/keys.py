"""What the keys of camera files mean: the usual spellings, and what is let pass."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from mctrack_ros.ground.errors import CalibrationError

CAMERA: Mapping[str, tuple[str, ...]] = {
    'matrix': (
        'cameramatrix', 'intrinsicmatrix', 'cameraintrinsics', 'cameraintrinsic', 'intrinsics',
        'intrinsic', 'cammatrix', 'cammat', 'mtx', 'k',
    ),
    'lens': (
        'distortioncoefficients', 'distortioncoefficient', 'distortioncoeffs', 'distortioncoeff',
        'distcoefficients', 'distcoeffs', 'distcoeff', 'distcoefs', 'distcoef',
        'distortionparameters', 'distortionparams', 'distortionvector', 'distortion',
        'cameradistortion', 'lensdistortion', 'dist', 'd',
    ),
    'model': (
        'distortionmodel', 'distortiontype', 'cameramodel', 'cameratype', 'lensmodel', 'lenstype',
        'model', 'modeltype', 'projectionmodel',
    ),
    'fisheye': ('fisheyemodel', 'fisheye', 'isfisheye', 'usefisheye'),
    'width': ('imagewidth', 'width', 'imgwidth', 'framewidth', 'camerawidth'),
    'height': ('imageheight', 'height', 'imgheight', 'frameheight', 'cameraheight'),
    'size': (
        'cameraresolution', 'imageresolution', 'resolution', 'imagesize', 'imgsize', 'framesize',
        'camerasize', 'size', 'dim',
    ),
    'skew': ('skew', 'skewness'),
    'binning_x': ('binningx',),
    'binning_y': ('binningy',),
    'region': ('roi',),
    'turn': ('rvec', 'rotationvector', 'rotationmatrix', 'rmat', 'r'),
    'shift': ('tvec', 'translationvector', 'tmat', 't'),
    'attitude': ('rotation', 'orientation', 'quaternion'),
    'place': ('translation', 'position'),
    'pose': ('extrinsics', 'transform', 'pose'),
    'transforms': ('transforms',),
}  # fmt: skip
"""Meanings of keys in files of OpenCV's, ROS's and of scripts, without case and punctuation."""
MESSAGE: Mapping[str, tuple[str, ...]] = {
    **CAMERA,
    'turn': CAMERA['turn'][:-1],
    'shift': CAMERA['shift'][:-1],
}
"""The same in a printed `sensor_msgs/CameraInfo`, where r and p are of rectified images."""
KALIBR: Mapping[str, tuple[str, ...]] = {
    'camera': ('cameramodel',),
    'intrinsics': ('intrinsics',),
    'model': ('distortionmodel',),
    'lens': ('distortioncoeffs',),
    'size': ('resolution',),
    'topic': ('rostopic',),
}
"""Meanings of keys below one camera of Kalibr's."""
TSAI: Mapping[str, tuple[str, ...]] = {
    'number': (
        'width', 'height', 'ncx', 'nfx', 'dx', 'dy', 'dpx', 'dpy', 'focal', 'kappa1', 'cx', 'cy',
        'sx', 'tx', 'ty', 'tz', 'rx', 'ry', 'rz', 'name',
    ),
}  # fmt: skip
"""Attributes in a Tsai file; those of the sensor's elements say what dpx and dpy say."""
_PASSED = re.compile(
    r'.*(date|time|err(or)?s?|rms|std(dev)?|deviations?|uncertaint(y|ies)|covariance|comments?|'
    r'description|serial(number)?|version|path|file(name)?|count)'
    r'|(board|square|pattern|marker|chess|checker|tag|target|aruco|charuco|circle|grid|perview).*'
    r'|n(rof|umberof|um)?(frames|images|views|samples|boards)(touse)?'
    r'|(image|object|corner)(points?|corners?|list|ids)|flags?(value)?|calibrationflags?'
    r'|fix[a-z0-9]*|aspectratio|calibrate[a-z]*|zerotangentdist|releaseobject|typeid'
    r'|(camera|frame|childframe)?(name|id)|header|(ros)?topic'
    r'|rvecs|tvecs|extrinsicparameters|tcncnm1|tcamimu|timucam|timeshiftcamimu|camoverlaps|linedelay'
    r'|r|p|rectificationmatrix|projectionmatrix|(optimal)?newcameramatrix|timeoffset'
)
"""Keys without a word on where a raw image shows things: dates, errors, boards."""
_TELLING = re.compile(
    r'.*(lens|model|size|width|height|resolution|dist(?!ance)|fisheye|omni|skew|binning|roi|crop|'
    r'focal|intrinsic|extrinsic|matrix|pixel|sensor|scale|zoom|shear|rotat|translat|mirror|flip|'
    r'unit|pose|radial|tangential|prism|kappa|rectified|offset|decimat|subsampl|resiz|stretch).*'
    r'|xi|alpha|beta|gamma|rows|cols|columns|[kps][0-9]|f|f[xyuvc]?|[cs][xyuv]|[uv]0|tau[xy]?|[wh]'
)
"""Keys that may say where an image shows things."""
_LENS = re.compile(r'fish.?eye|equi(distant|solid)|stereographic|orthographic|omni|kannala|brown')
"""Values that name a lens, whatever their key is."""
_MATRICES = (*CAMERA['matrix'], 'm')
_PAIR = re.compile(r'[rp][12]|[qef]|(essential|fundamental)(matrix)?')
_SIDE = re.compile(r'(left|right|camera[0-9]|cam[0-9])?(.*?)(left|right|[lr]|cam[0-9]|[0-9])?')


def plain(name: object) -> str:
    """Return a name without case and punctuation: so spellings of one differ."""
    return re.sub(r'[^a-z0-9]', '', str(name).lower())


def meaning_of(key: object, spellings: Mapping[str, tuple[str, ...]] = CAMERA) -> str:
    """Return what a key means; empty: nothing that is known."""
    known = plain(key)
    return next((each for each, names in spellings.items() if known in names), '')


def spelling_table(values: Mapping[Any, Any]) -> Mapping[str, tuple[str, ...]]:
    """Return the meanings for a camera file: those of a message if it is one that was printed."""
    known = {plain(key) for key in values}
    return MESSAGE if {'k', 'd', 'r', 'p'} <= known else CAMERA


def sorted_keys(
    values: Mapping[Any, Any], where: str | Path, spellings: Mapping[str, tuple[str, ...]]
) -> dict[str, list[Any]]:
    """
    Return which keys of a file have which meaning.

    Parameters
    ----------
    values : mapping
        What the file holds.
    where : str or Path
        What it is from, to name.
    spellings : mapping of str to tuple of str
        What each meaning is called, without case and punctuation.

    Raises
    ------
    CalibrationError
        If a key may say where things are seen and is not known, or the file is of two cameras.

    """
    found: dict[str, list[Any]] = {}
    strange = []
    for key in values:
        meaning = meaning_of(key, spellings)
        if meaning:
            found.setdefault(meaning, []).append(key)
        elif not _PASSED.fullmatch(plain(key)):
            strange.append(key)
    pair = [
        key
        for key in strange
        if not isinstance(values[key], int | float | str)
        and (_PAIR.fullmatch(plain(key)) or _is_a_side(key, (*_MATRICES, *CAMERA['lens'])))
    ]
    if pair:
        raise CalibrationError(
            f'{where}: it is of several cameras ({_listed(pair)}): write one of them, as '
            'camera_matrix and distortion_coefficients, into a file of its own'
        )
    telling = [key for key in strange if _tells(key, values[key])]
    if telling:
        raise CalibrationError(
            f'{where}: {_listed(telling)}: not known here, and may say where an image shows '
            'things: take it out of the file if it does not'
        )
    return found


def states_camera(values: Mapping[Any, Any]) -> bool:
    """Tell whether a file holds the matrix of a camera, or of each of a pair."""
    return any(
        not (isinstance(value, Mapping) and 'data' not in value)
        if meaning_of(key) == 'matrix'
        else _is_a_side(key, _MATRICES) and not isinstance(value, int | float)  # k1 of a lens
        for key, value in values.items()
    )


def _tells(key: object, value: object) -> bool:
    """Tell whether a key, its value, or a key below it may say where an image shows things."""
    if _TELLING.fullmatch(plain(key)):
        return True
    if isinstance(value, Mapping):
        return any(_tells(*each) for each in value.items())
    return isinstance(value, str) and _LENS.search(value.lower()) is not None


def _is_a_side(key: object, names: Iterable[str]) -> bool:
    """Tell whether a key is one of several cameras': K1, cameraMatrixLeft, right_D ..."""
    side = _SIDE.fullmatch(plain(key))
    return side is not None and bool(side[1] or side[3]) and side[2] in names


def _listed(keys: Iterable[object]) -> str:
    return ', '.join(str(key) for key in keys)
