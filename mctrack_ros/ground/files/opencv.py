"""Files as OpenCV stores them (`cv2.FileStorage`): XML or YAML."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from mctrack_ros.ground.camera.stored import StoredCamera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.keys import meaning_of

MOST_NUMBERS = 1000
"""Longer lists are no part of a camera; OpenCV counts to each entry from the first."""
DEEPEST = 3
"""How far lists and mappings of a camera lie in one another at most."""


def read_opencv(path: str | Path) -> dict[str, Any]:
    """
    Return what a file of OpenCV's holds, by its keys; None for lists that mean nothing here.

    Raises
    ------
    CalibrationError
        If the file cannot be read; names it.

    """
    try:
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    except (cv2.error, SystemError) as error:
        raise CalibrationError(f'{path}: OpenCV cannot read it') from error
    try:
        root = storage.root()
        keys = list(map(str, root.keys())) if root.isMap() else []
        values = {key: _held(root.getNode(key), bool(meaning_of(key))) for key in keys}
    finally:
        storage.release()
    twice = sorted(key for key, count in Counter(keys).items() if count > 1)
    if twice:
        raise CalibrationError(f'{path}: {", ".join(twice)} stands twice in it: keep one')
    if 'fisheye_model' not in values and _comment_names_a_fisheye(path):
        values['fisheye_model'] = 1
    return values


def _comment_names_a_fisheye(path: str | Path) -> bool:
    """Tell whether OpenCV's sample wrote a flag that only fisheyes have; it did not say more."""
    return any(flag in Path(path).read_bytes() for flag in (b'+fix_skew', b'+recompute_extrinsic'))


def _held(node: cv2.FileNode, lists: bool, depth: int = 0) -> Any:
    """Return a number, a text, what is below keys, and if wanted a list of these."""
    if depth > DEEPEST or (node.isSeq() and not lists):
        return None
    if node.isMap():
        keys = map(str, node.keys())
        return {key: _held(node.getNode(key), lists, depth + 1) for key in keys}
    if node.isSeq():
        if node.size() > MOST_NUMBERS:
            return [math.nan] * node.size()
        # one by one: some OpenCV garble whole matrices
        return [_held(node.at(index), lists, depth + 1) for index in range(node.size())]
    if node.isInt():
        return int(node.real())
    if node.isReal():
        return node.real()
    return node.string() if node.isString() else None


def write_opencv(camera: StoredCamera, image_size: tuple[int, int], path: str | Path) -> None:
    """Write a camera and, where it is known, its pose: XML or YAML by the file's ending."""
    across, down, x, y = camera.intrinsics.tolist()
    Path(path).touch()  # OpenCV does not say why it cannot write
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write('image_width', int(image_size[0]))
    storage.write('image_height', int(image_size[1]))
    storage.write('camera_matrix', np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]]))
    storage.write('distortion_coefficients', camera.distortion[None])
    if camera.pose is not None:
        storage.write('rvec', cv2.Rodrigues(camera.pose.rotation)[0])
        storage.write('tvec', camera.pose.translation[:, None])
    storage.release()
