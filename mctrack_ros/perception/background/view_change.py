"""Much that changes at once: whether it shows the same scene, lit anew or shifted."""

from __future__ import annotations

from operator import itemgetter

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.background.objects import DARK_LEVEL
from mctrack_ros.perception.camera_shift.phase_correlation import (
    Floats32,
    coarse_shifts,
    reduced,
)

Image = NDArray[np.uint8]
LEAST_LIKENESS = 0.5
"""Correlation of structure in what has changed, from which it is the same scene.
Whom 300 images of each of four terrace cameras show makes it .30 at most, lamp and turn .7."""
LEAST_SHARE = 0.03  # of the image, beside people
LOCAL_PX = 31  # over which light is about the same


def scene_after(image: Image, model: Image, changed: Image, people: Image) -> Image | None:
    """
    Return the background that an image shows, if what has changed is light or the view itself.

    Light keeps the structure of what it falls on, and a camera that is turned shows it elsewhere;
    people hide it. Where people are the background is as it was, moved and lit as around them.

    Parameters
    ----------
    image, model : (h, w, 3) uint8 array
        Image and background.
    changed : (h, w) uint8 array
        Where they differ, not 0.
    people : (h, w) uint8 array
        Not 0 where somebody is known to be.

    Returns
    -------
    (h, w, 3) uint8 array or None
        None: the scene is not found again.

    """
    grey = (cv2.cvtColor(each, cv2.COLOR_BGR2GRAY) for each in (image, model))
    new, old = (reduced(np.asarray(each, np.uint8)) for each in grey)
    size = new.shape[1], new.shape[0]
    other = cv2.bitwise_and(changed, cv2.bitwise_not(people))
    where = cv2.resize(other, size, interpolation=cv2.INTER_AREA) > 127
    if where.mean() < LEAST_SHARE:
        return None
    shifts = [(0, 0), *coarse_shifts(new, old)]
    found = ((_likeness(new, old, where, each), each) for each in shifts)
    likeness, shift = max(found, key=itemgetter(0))
    if likeness < LEAST_LIKENESS:
        return None
    scale = image.shape[1] / size[0]
    return _filled(image, model, people, round(shift[0] * scale), round(shift[1] * scale))


def _filled(image: Image, model: Image, people: Image, right: int, down: int) -> Image:
    """Return an image whose people are replaced by a background that is moved so far, px."""
    move = np.array([[1.0, 0, right], [0, 1.0, down]])
    moved = cv2.warpAffine(model, move, image.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)
    beside = cv2.warpAffine(people, move, people.shape[::-1])
    hidden = np.asarray(cv2.bitwise_or(people, beside), np.uint8)
    after = _lit(np.asarray(moved, np.uint8), image, hidden)
    return np.asarray(np.where((hidden > 0)[..., None], after, image), np.uint8)


def _likeness(
    new: Floats32, old: Floats32, where: NDArray[np.bool_], shift: tuple[int, int]
) -> float:
    """Return the correlation of two structures, one shifted, in a part."""
    one, other = new[where], np.roll(old, shift[::-1], axis=(0, 1))[where]
    one, other = one - one.mean(), other - other.mean()
    return float(one @ other / (np.linalg.norm(one) * np.linalg.norm(other) + 1e-9))


def _lit(model: Image, image: Image, hidden: Image) -> Image:
    """Return a model in the light that an image shows around what is hidden."""
    old, new = (np.log(each.astype(np.float32) + DARK_LEVEL) for each in (model, image))
    seen = (hidden == 0).astype(np.float32)
    weight = cv2.blur(seen, (LOCAL_PX, LOCAL_PX))[..., None]
    light = cv2.blur((new - old) * seen[..., None], (LOCAL_PX, LOCAL_PX)) / (weight + 1e-3)
    lit = np.clip(np.rint(np.exp(old + light) - DARK_LEVEL), 0, 255)
    return np.asarray(lit, np.uint8)
