"""Clock offsets and ground biases of cameras, from targets that several of them see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from mctrack_ros.fusion.clock_offsets.moments import INSTANT_S, INSTANTS, BySet, Moments
from mctrack_ros.tracking.kalman import MEDIAN_SQUARED

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Check = Callable[[], None]
"""May raise, so that nobody has to wait for what takes long."""

WHITE, LASTING, CONSTANT, LASTING_S = 0.2, 0.5, 0.3, 0.6
"""Of the errors of a view: shares that are new each instant, last for so long, s, and stay."""
FREEDOM = 4.0
"""Degrees of freedom of their t distribution: a wrong sighting counts little."""
ROUNDS = 4
"""Of weighing and solving."""
LAGS = 2
"""Number of blocks after which the errors of a target are independent."""
CONFIDENCE = 0.975


def _whitening() -> Floats:
    """Return the (m, m) matrix that makes errors of a block as alike and as independent."""
    apart = INSTANT_S * np.abs(np.subtract.outer(np.arange(INSTANTS), np.arange(INSTANTS)))
    alike = CONSTANT + LASTING * np.exp(-apart / LASTING_S) + WHITE * np.eye(INSTANTS)
    return np.asarray(np.linalg.cholesky(np.linalg.inv(alike)).T)


WHITENING = _whitening()


@dataclass(frozen=True, eq=False, slots=True)
class Solution:
    """
    Offsets of c cameras from the first one of each group.

    Attributes
    ----------
    offset : (c,) array
        By how much each clock is ahead, s; NaN: the camera shares no view.
    bias : (c, 2) array
        Where each places targets, m.
    group : (c,) int array
        First camera of those that are connected by common views; -1: none are.
    influence : (g, c) array
        What each target in each block adds to the offsets, s.
    target, block : (g,) int arrays
        Which target, in which block.

    """

    offset: Floats
    bias: Floats
    group: Indices
    influence: Floats
    target: Indices
    block: Indices

    def between(self, camera: int, reference: int) -> tuple[float, float, float]:
        """
        Return by how much a camera's clock is ahead of another's of its group.

        Returns
        -------
        offset, deviation, half : float
            With its standard deviation, and half the width of its 95 % interval, s.

        """
        if camera == reference:
            return 0.0, 0.0, 0.0
        offset = float(self.offset[camera] - self.offset[reference])
        score = self.influence[:, camera] - self.influence[:, reference]
        squares, variance = score**2, self._variance(score)
        if not variance > 0:
            return offset, np.inf, np.inf
        freedom = max(3 * squares.sum() ** 2 / (squares**2).sum() - 1, 1.0)
        deviation = float(np.sqrt(variance))
        return offset, deviation, float(stdtrit(freedom, CONFIDENCE)) * deviation

    def _variance(self, score: Floats) -> float:
        """Return the variance of a sum of scores that depend on those shortly before (HAC)."""
        count = len(score)
        if count < 2:
            return np.inf
        total = float(score @ score)
        key = self.target * (1 << 32) + self.block
        for lag in range(1, LAGS + 1):
            at = np.minimum(np.searchsorted(key, key + lag), count - 1)
            is_there = key[at] == key + lag
            total += 2 * (1 - lag / (LAGS + 1)) * float(score[is_there] @ score[at[is_there]])
        return total * count / (count - 1)


def solve(moments: BySet, cameras: int, check: Check = lambda: None) -> Solution:
    """
    Estimate offsets and biases jointly, by generalised estimating equations.

    At an instant, cameras of one target say its place there, plus each its bias, less the velocity
    times what its clock is ahead, plus noise. The place is eliminated, as nobody knows it. The
    velocity is measured, too. As an instrument it is that of all cameras; where its square is
    needed, it is the product of what each camera says with what the others say, in which no noise
    is squared: who stands still tells nothing, however noisy. A working correlation of the errors
    (Liang and Zeger 1986, "Longitudinal data analysis using generalized linear models") weighs the
    instants of a block; what the covariance says is measured: of the sums over a target and block,
    which depend on those shortly before (Newey and West 1987, "A simple, positive semi-definite,
    heteroskedasticity and autocorrelation consistent covariance matrix").

    Parameters
    ----------
    moments : BySet
        What is seen.
    cameras : int
        How many there are.
    check : callable
        Called again and again; what it raises ends the estimate.

    """
    group = _groups(moments, cameras)
    values, blank = np.zeros((3, cameras)), np.where(group >= 0, 0.0, np.nan)
    free = np.flatnonzero(np.tile((group >= 0) & (group != np.arange(cameras)), 3))
    sets = [_Set(each, one, cameras) for each, one in moments.items()]
    clusters = [np.column_stack([one.target, one.block]) for one in moments.values()]
    known, which = np.unique(
        np.concatenate([np.zeros((0, 2), np.int64), *clusters]), axis=0, return_inverse=True
    )
    scale = np.ones(cameras)
    for _ in range(ROUNDS):
        scale = _scales(sets, values, scale, check)
        slope, scores = _equations(sets, values, scale, check)
        step = np.linalg.lstsq(slope[np.ix_(free, free)], scores.sum(axis=0)[free], rcond=None)[0]
        values.ravel()[free] += step
    slope, scores = _equations(sets, values, scale, check, steeper=True)
    each = np.zeros_like(scores)
    each[:, free] = np.linalg.lstsq(slope[np.ix_(free, free)], scores[:, free].T, rcond=None)[0].T
    influence = np.zeros((len(known), cameras))
    np.add.at(influence, which.ravel(), each[:, :cameras])
    offset, bias = values[0] + blank, values[1:].T + blank[:, None]
    return Solution(offset, bias, group, influence, known[:, 0], known[:, 1])


class _Set:
    """
    The moments of the same n cameras, and how these stand in the whole.

    Local unknowns are the n offsets, then the n biases along each axis.
    """

    def __init__(self, cameras: tuple[int, ...], moments: Moments, total: int) -> None:
        self.moments, self.cameras, self._total = moments, list(cameras), total
        self.unknown = np.concatenate([np.array(cameras) + total * kind for kind in range(3)])

    def distances(self, values: Floats, scale: Floats) -> Floats:
        """Return the (s, m, n) squared distances of each camera from what the others say."""
        information = self._information(scale)
        place = self._left(values)
        pull = np.einsum('smnij,smnj->smni', information, place)
        others = information.sum(axis=2, keepdims=True) - information
        middle = np.linalg.solve(others, (pull.sum(axis=2, keepdims=True) - pull)[..., None])
        away = place - middle[..., 0]
        spread = np.linalg.inv(information) + np.linalg.inv(others)
        return np.asarray((away * np.linalg.solve(spread, away[..., None])[..., 0]).sum(axis=3))

    def equations(self, values: Floats, scale: Floats, steeper: bool) -> tuple[Floats, Floats]:
        """
        Return the (3 n, 3 n) derivative of the local equations and the (s, 3 n) scores.

        What is far off counts little in the residuals; the instruments know nothing of that.
        Steeper: with the derivative of that, too.
        """
        known = self.moments.is_known[:, :, None, None, None]
        outer = self._outer(self._information(scale)) * known[..., None]
        residual = np.einsum('smcidj,smdj->smci', outer, self._left(values))
        squared, freedom = (residual**2).sum(axis=(2, 3)), 2.0 * (len(self.cameras) - 1)
        weight = (FREEDOM + freedom) / (FREEDOM + squared)
        scores = np.einsum(
            'smcip,smci->sp',
            self._whitened(self._design(outer, self.moments.velocity)),
            self._whitened(residual * weight[:, :, None, None]),
            optimize=True,
        )
        if steeper:
            weight = weight * (1 - 2 * squared / (freedom * (FREEDOM + squared)))
        return self._derivative(outer, weight), scores

    def _derivative(self, outer: Floats, weight: Floats) -> Floats:
        """Return the (3 n, 3 n) derivative for the (s, m) weights of moments."""
        count, weight = len(self.cameras), weight[:, :, None, None, None]
        design = self._design(outer, self.moments.velocity)
        slope = _product(self._whitened(design), self._whitened(design * weight))
        slope[:count, :count] = 0.0
        for camera in range(count):
            own = self._moved(outer, self.moments.part[:, :, camera])
            other = self._moved(outer, self.moments.rest[:, :, camera])
            crossed = _product(self._whitened(own), self._whitened(other * weight))
            slope[:count, :count] += (crossed + crossed.T) / 2
        return slope

    def _information(self, scale: Floats) -> Floats:
        return np.asarray(self.moments.information / scale[self.cameras, None, None])

    def _left(self, values: Floats) -> Floats:
        """Return the (s, m, n, 2) places less what biases and offsets make of them."""
        offset, bias = values[0, self.cameras], values[1:, self.cameras].T
        moved = self.moments.velocity[:, :, None] * offset[:, None]
        return np.asarray(self.moments.place + moved - bias)

    def _outer(self, information: Floats) -> Floats:
        """Return (s, m, n, 2, n, 2): what whitens the cameras and takes their mean place away."""
        root = np.swapaxes(np.linalg.cholesky(information + 1e-12 * np.eye(2)), -1, -2)
        total = information.sum(axis=2) + 1e-9 * np.eye(2)
        share = np.linalg.solve(total[:, :, None], information)
        outer = -np.einsum('smcij,smdjk->smcidk', root, share)
        for camera in range(len(self.cameras)):
            outer[:, :, camera, :, camera, :] += root[:, :, camera]
        return np.asarray(outer)

    def _moved(self, outer: Floats, velocity: Floats) -> Floats:
        """Return the design of the offsets, (s, m, n, 2, n), for (s, m, 2) velocities."""
        return np.asarray(-np.einsum('smcidj,smj->smcid', outer, velocity))

    def _design(self, outer: Floats, velocity: Floats) -> Floats:
        """Return the design of all local unknowns, (s, m, n, 2, 3 n)."""
        moved = self._moved(outer, velocity)
        return np.concatenate([moved, outer[..., 0], outer[..., 1]], axis=4)

    @staticmethod
    def _whitened(values: Floats) -> Floats:
        """Apply the working correlation along the instants, the second axis."""
        return np.moveaxis(np.tensordot(WHITENING, values, axes=(1, 1)), 0, 1)


def _product(one: Floats, other: Floats) -> Floats:
    """Return the products of the last axes, summed over all others."""
    return np.asarray(np.tensordot(one, other, axes=([0, 1, 2, 3], [0, 1, 2, 3])))


def _scales(sets: list[_Set], values: Floats, scale: Floats, check: Check) -> Floats:
    """Return by how much each camera varies more than it says."""
    found: list[list[Floats]] = [[] for _ in scale]
    for one in sets:
        check()
        squared = one.distances(values, scale)
        for index, camera in enumerate(one.cameras):
            found[camera].append(squared[..., index][one.moments.is_known])
    medians = [np.median(np.concatenate(own)) if own else MEDIAN_SQUARED for own in found]
    return np.asarray(np.maximum(scale * np.array(medians) / MEDIAN_SQUARED, 1e-6))


def _equations(
    sets: list[_Set], values: Floats, scale: Floats, check: Check, steeper: bool = False
) -> tuple[Floats, Floats]:
    """Return the (3 c, 3 c) derivative and the (rows, 3 c) scores of all sets."""
    size = values.size
    slope, scores = np.zeros((size, size)), [np.zeros((0, size))]
    for one in sets:
        check()
        local, own = one.equations(values, scale, steeper)
        slope[np.ix_(one.unknown, one.unknown)] += local
        placed = np.zeros((len(own), size))
        placed[:, one.unknown] = own
        scores.append(placed)
    return slope, np.concatenate(scores)


def _groups(moments: BySet, cameras: int) -> Indices:
    """Return for each camera the first of those it is connected with; -1: it is alone."""
    group = np.full(cameras, -1)
    for seen in moments:
        known = [group[camera] for camera in seen if group[camera] >= 0]
        first = min([*known, *seen])
        for old in known:
            group[group == old] = first
        group[list(seen)] = first
    return group
