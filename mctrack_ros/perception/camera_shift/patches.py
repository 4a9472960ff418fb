"""Patches of a reference image, found again in later ones; how the image moved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]

COLUMNS, ROWS = 8, 6
ORDER = 29 * np.arange(COLUMNS * ROWS) % (COLUMNS * ROWS)
"""Of cells that are sought: the first few are spread over the image."""

HALF_PX = 10  # a patch is 21 x 21 px
CORNER_PX = 7  # window in which the gradients of a corner are summed
LEAST_CONTRAST = 2.0  # standard deviation, grey levels
LEAST_SCORE = 0.7  # normalised correlation
TOLERANCE_PX = 1.0  # of a patch from the common shift
LEAST_PATCHES = 8  # two fix a similarity, which has four unknowns; the others must agree
LEAST_SHARE = 0.5  # of the patches found must agree: no other shift can have more
PROBES = 16  # patches after which an image of which hardly any is found is given up
LEAST_PROBED = 2  # of these, for the image to be searched on
LEAST_SPREAD = 0.1  # of the image's diagonal


def prepared(image: NDArray[np.uint8]) -> Grey:
    """Return the grey image, smoothed so that noise does not hide its texture."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return cv2.GaussianBlur(grey, (3, 3), 0)  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class Motion:
    """
    How an image lies over its reference: a shift, a turn and a zoom about the middle.

    A point p moves by ``shift + [[zoom, -turn], [turn, zoom]] (p - middle)``.

    Attributes
    ----------
    right, down : float
        Shift of the image's middle, px.
    zoom : float
        Growth, relative.
    turn : float
        Clockwise as seen, rad for small turns.

    """

    right: float = 0.0
    down: float = 0.0
    zoom: float = 0.0
    turn: float = 0.0

    def at(self, offset: Floats) -> Floats:
        """Return how far (n, 2) points, px from the middle, move, (n, 2) px."""
        matrix = np.array([[self.zoom, -self.turn], [self.turn, self.zoom]])
        return np.asarray(offset @ matrix.T + [self.right, self.down])

    def size(self, image_size: tuple[int, int]) -> float:
        """Return the root mean square of the shift over an image of (width, height), px."""
        spread = (image_size[0] ** 2 + image_size[1] ** 2) / 12
        change = self.zoom**2 + self.turn**2
        return float(np.sqrt(self.right**2 + self.down**2 + change * spread))

    def minus(self, other: Motion) -> Motion:
        """Return the difference, exact to first order."""
        return Motion(
            self.right - other.right,
            self.down - other.down,
            self.zoom - other.zoom,
            self.turn - other.turn,
        )


def median_motion(motions: list[Motion]) -> Motion:
    """Return the medians of shifts, zooms and turns."""
    rows = [(one.right, one.down, one.zoom, one.turn) for one in motions]
    return Motion(*np.median(np.array(rows), axis=0).tolist())


class Patches:
    """
    At most one patch in each cell of the image, where it has its strongest corner.

    Parameters
    ----------
    grey : (h, w) uint8 array
        The reference, from `prepared`.
    allowed : (h, w) uint8 array or None
        0 where no patch may be.

    """

    def __init__(self, grey: Grey, allowed: Grey | None) -> None:
        height, width = grey.shape
        self._allowed = allowed
        self._middle = np.array([width, height]) / 2
        self._diagonal = float(np.hypot(width, height))
        self._patch: list[Grey | None] = [None] * (COLUMNS * ROWS)
        self._place: Floats = np.zeros((COLUMNS * ROWS, 2))
        self._forget_counts()
        self._fill(grey, Motion())

    def rebase(self, motion: Motion) -> None:
        """Let a motion be none from now on."""
        self._place += motion.at(self._place - self._middle)

    def renew(self, grey: Grey, motion: Motion) -> None:
        """Exchange patches that were not found most of the time, under a known motion."""
        for cell in np.flatnonzero(2 * self._found < self._tried).tolist():
            self._patch[cell] = None
        self._fill(grey, motion)
        self._forget_counts()

    def motion(self, grey: Grey, guess: Motion, search_px: int) -> tuple[Motion, int] | None:
        """
        Return how an image lies over the reference and how many patches agree; None: too few.

        Parameters
        ----------
        grey : (h, w) uint8 array
            The image, from `prepared`.
        guess : Motion
            About how it lies.
        search_px : int
            How far each patch is searched about that, px.

        """
        there, found, judged = self._search(grey, guess, search_px)
        place = (self._place - self._middle)[there]
        agreed = _agreement(place, found, self._diagonal)
        if agreed is not None:
            self._tried[judged] += 1
            self._found[there] += 1
        return agreed

    def _search(
        self, grey: Grey, guess: Motion, search_px: int
    ) -> tuple[NDArray[np.int64], Floats, NDArray[np.int64]]:
        """Return cells that were found, (n, 2) places from the middle, cells that were sought."""
        expected = np.rint(self._place + guess.at(self._place - self._middle)).astype(int)
        reach = HALF_PX + search_px
        low, high = expected - reach, expected + reach + 1
        inside = (low >= 0).all(axis=1) & (high <= grey.shape[::-1]).all(axis=1)
        there: list[int] = []
        judged: list[int] = []
        found = []
        for cell in ORDER[np.isin(ORDER, np.flatnonzero(inside))].tolist():
            patch = self._patch[cell]
            if patch is None:
                continue
            if len(judged) == PROBES and len(there) < LEAST_PROBED:
                break
            judged.append(cell)
            (left, top), (right, bottom) = low[cell], high[cell]
            score = cv2.matchTemplate(grey[top:bottom, left:right], patch, cv2.TM_CCOEFF_NORMED)
            peak = _peak(score)
            if peak is not None:
                there.append(cell)
                found.append((expected[cell, 0] + peak[0], expected[cell, 1] + peak[1]))
        place = np.array(found, float).reshape(-1, 2) - self._middle
        return np.array(there, np.int64), place, np.array(judged, np.int64)

    def _forget_counts(self) -> None:
        self._tried = np.zeros(COLUMNS * ROWS, np.int64)
        self._found = np.zeros(COLUMNS * ROWS, np.int64)

    def _fill(self, grey: Grey, motion: Motion) -> None:
        """Choose patches in the cells that have none."""
        height, width = grey.shape
        for cell, patch in enumerate(self._patch):
            if patch is not None:
                continue
            row, column = divmod(cell, COLUMNS)
            top, bottom = height * row // ROWS, height * (row + 1) // ROWS
            left, right = width * column // COLUMNS, width * (column + 1) // COLUMNS
            corner = self._corner(grey, (left, top, right, bottom))
            if corner is None:
                continue
            x, y = corner
            self._patch[cell] = _cut(grey, x, y).copy()
            now = np.array([[x, y]], float)
            self._place[cell] = (now - motion.at(now - self._middle))[0]

    def _corner(self, grey: Grey, cell: tuple[int, int, int, int]) -> tuple[int, int] | None:
        """Return where in a cell the strongest corner is, if a patch there has contrast."""
        left, top, right, bottom = cell
        margin = HALF_PX + CORNER_PX
        left, top = max(left, margin), max(top, margin)
        right, bottom = min(right, grey.shape[1] - margin), min(bottom, grey.shape[0] - margin)
        if left >= right or top >= bottom:
            return None
        strength = cv2.cornerMinEigenVal(grey[top:bottom, left:right], CORNER_PX)
        if self._allowed is not None:
            strength = np.where(self._allowed[top:bottom, left:right] > 0, strength, 0.0)
        y, x = np.unravel_index(int(strength.argmax()), strength.shape)
        place = (left + int(x), top + int(y))
        hidden = self._allowed is not None and not _cut(self._allowed, *place).all()
        if hidden or _cut(grey, *place).std() < LEAST_CONTRAST:
            return None
        return place


def _agreement(place: Floats, found: Floats, diagonal_px: float) -> tuple[Motion, int] | None:
    """Return the motion on which most patches, over some of the image, agree."""
    if len(place) < LEAST_PATCHES:
        return None
    matrix, inliers = cv2.estimateAffinePartial2D(place, found, ransacReprojThreshold=TOLERANCE_PX)
    if matrix is None:
        return None
    agree = inliers[:, 0] > 0
    count = int(np.count_nonzero(agree))
    spread = np.sqrt(place[agree].var(axis=0).sum())
    if count < max(LEAST_PATCHES, LEAST_SHARE * len(place)) or spread < LEAST_SPREAD * diagonal_px:
        return None
    grown, turned = float(matrix[0, 0]) - 1, float(matrix[1, 0])
    return Motion(float(matrix[0, 2]), float(matrix[1, 2]), grown, turned), count


def _cut(grey: Grey, x: int, y: int) -> Grey:
    return grey[y - HALF_PX : y + HALF_PX + 1, x - HALF_PX : x + HALF_PX + 1]


def _peak(score: NDArray[Any]) -> tuple[float, float] | None:
    """Return where a score is highest, from its middle, finer than a pixel; None at its rim."""
    _, best, _, (x, y) = cv2.minMaxLoc(score)
    last = len(score) - 1
    if best < LEAST_SCORE or not (0 < x < last and 0 < y < last):
        return None
    across = _vertex(score[y, x - 1], best, score[y, x + 1])
    down = _vertex(score[y - 1, x], best, score[y + 1, x])
    return x + across - last / 2, y + down - last / 2


def _vertex(before: float, top: float, after: float) -> float:
    """Return where the parabola through three equally spaced values is highest."""
    curvature = before - 2 * top + after
    return 0.0 if curvature >= 0 else float((before - after) / (2 * curvature))
