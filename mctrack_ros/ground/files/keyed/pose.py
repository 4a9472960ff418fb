"""Where a camera is, from named values: as TF has it, or OpenCV."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from mctrack_ros.ground.camera.stored import Pose
from mctrack_ros.ground.files.keyed.stated import Stated


def pose_in(values: Mapping[Any, Any], where: str | Path) -> Pose:
    """
    Return where a camera is.

    Parameters
    ----------
    values : mapping
        ``translation`` and ``rotation`` of the optical frame in the ground frame, a mapping or a
        list each, metres and a quaternion x, y, z, w, as TF has them; below ``extrinsics``,
        ``transform`` or ``transforms`` or not. Or ``rvec`` or ``R`` and ``tvec`` or ``T`` of
        OpenCV, from world to camera.
    where : str or Path
        What they are from, to name.

    Raises
    ------
    CalibrationError
        If there is no pose, more than one, or something that is not known; names it.

    """
    stated = Stated(values, where)
    _check_direction(values, stated)
    pose = stated_pose(stated)
    if pose is None:
        raise stated.error(
            'no pose: expected a translation of x, y, z and a rotation of x, y, z, w, as TF has '
            'them; or rvec and tvec, or R and T, of OpenCV'
        )
    return pose


def stated_pose(stated: Stated) -> Pose | None:
    """
    Return the pose that a file states, if any.

    Raises
    ------
    CalibrationError
        As `pose_in`.

    """
    poses = [
        read(stated)
        for meanings, read in (
            (('pose', 'transforms'), _pose_below),
            (('place', 'attitude'), _frame_pose),
            (('turn', 'shift'), _opencv_pose),
        )
        if any(meaning in stated for meaning in meanings)
    ]
    if len(poses) > 1:
        raise stated.error(f'{len(poses)} poses: keep one')
    return poses[0] if poses else None


def _check_direction(values: Mapping[Any, Any], stated: Stated) -> None:
    """Refuse a transform of the ground in the optical frame, where frames tell."""
    header = values.get('header')
    parent = str(header.get('frame_id', '')) if isinstance(header, Mapping) else ''
    child = str(values.get('child_frame_id', ''))
    if 'optical' in parent and child and 'optical' not in child:
        raise stated.error(
            f'it is of {child} in {parent}, expected the optical frame in the ground frame: turn '
            'the two around'
        )


def _pose_below(stated: Stated) -> Pose:
    """Return the pose below a key of its own, or in a list of one."""
    below = stated.value('pose')
    if below is None:
        listed = stated.value('transforms')
        if not isinstance(listed, list) or len(listed) != 1:
            raise stated.error(
                'transforms: expected one alone, of the optical frame in the ground frame'
            )
        below = listed[0]
    if not isinstance(below, Mapping):
        raise stated.error(f'{stated.key("pose")} is {below!r}, expected translation and rotation')
    return pose_in(below, stated.where)


def _frame_pose(stated: Stated) -> Pose:
    """Return the pose of TF: where the optical frame is on the ground."""
    shift = _listed(stated.value('place'), 'xyz')
    turn = _listed(stated.value('attitude'), 'xyzw')
    if len(shift) != 3 or len(turn) != 4 or not np.isfinite([*shift, *turn]).all():
        raise stated.error('expected a translation of x, y, z and a rotation of x, y, z, w')
    if abs(np.linalg.norm(turn) - 1) > 1e-3:
        raise stated.error(f'the quaternion {turn} has not the length 1')
    return Pose.of_frame(shift, turn)


def _opencv_pose(stated: Stated) -> Pose:
    """Return the pose of OpenCV: from world to camera."""
    if not ('turn' in stated and 'shift' in stated):
        alone = stated.key('turn') or stated.key('shift')
        raise stated.error(f'{alone} alone is no pose: expected rvec and tvec, or R and T')
    turns = []
    for key, value in stated.each('turn'):
        turn = Stated({key: value}, stated.where).numbers('turn', 3, 9)
        turns.append(cv2.Rodrigues(turn)[0] if len(turn) == 3 else turn.reshape(3, 3))
    if not all(np.allclose(each, turns[0], rtol=0, atol=1e-6) for each in turns):
        keys = ' and '.join(key for key, _ in stated.each('turn'))
        raise stated.error(f'{keys} differ: keep one')
    return Pose(np.asarray(turns[0], np.float64), stated.numbers('shift', 3))


def _listed(values: Any, keys: str) -> list[float]:
    if isinstance(values, Mapping):
        values = [values.get(key) for key in keys]
    try:
        return [float(value) for value in values]
    except (TypeError, ValueError, OverflowError):
        return []
