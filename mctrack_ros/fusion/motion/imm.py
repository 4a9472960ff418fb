"""Two models that interact: their states are mixed, moved on, updated, judged and joined."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, compiled, inner
from mctrack_ros.fusion.motion.information import add, invert
from mctrack_ros.tracking.kalman import moved_on

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
_COLUMNS = (
    types.Array(types.f8, 2, 'A'),
    types.Array(types.f8, 3, 'A'),
    types.Array(types.f8, 3, 'A'),
    types.Array(types.f8, 4, 'A'),
    types.Array(types.f8, 2, 'A'),
)


@inner
def _mix(mean: Floats, covariance: Floats, share: float, centre: Floats, spread: Floats) -> None:
    """Write the moments (4,), (4, 4) of two states of which the second has that share."""
    both = share * (1.0 - share)
    for i in range(4):
        centre[i] = mean[0, i] + share * (mean[1, i] - mean[0, i])
        apart = both * (mean[1, i] - mean[0, i])
        for j in range(i + 1):
            value = covariance[0, i, j] + share * (covariance[1, i, j] - covariance[0, i, j])
            spread[i, j] = spread[j, i] = value + apart * (mean[1, j] - mean[0, j])


@compiled(types.void(*_COLUMNS, types.f8, types.f8))
def begin(
    mean: Floats, covariance: Floats, mode_mean: Floats, mode_covariance: Floats,
    mode_probability: Floats, calm_time: float, manoeuvre_time: float,
) -> None:  # fmt: skip
    """Let the modes (n, 2, ...) begin at the states (n, ...), as probable as they last long, s."""
    for track in range(len(mean)):
        mode_probability[track, 0] = calm_time / (calm_time + manoeuvre_time)
        mode_probability[track, 1] = manoeuvre_time / (calm_time + manoeuvre_time)
        for mode in range(2):
            mode_mean[track, mode] = mean[track]
            mode_covariance[track, mode] = covariance[track]


@compiled(types.void(*_COLUMNS, FLOATS_2D, types.f8, types.f8, types.f8))
def interact(
    mean: Floats, covariance: Floats, mode_mean: Floats, mode_covariance: Floats,
    mode_probability: Floats, transition: Floats, seconds: float, calm_density: float,
    manoeuvre_density: float,
) -> None:  # fmt: skip
    """
    Mix the modes by where those that are in each now were before, and predict them.

    Bar-Shalom, Li and Kirubarajan 2001, equations 11.6.6-7 to 11.6.6-10.

    Parameters
    ----------
    mean, covariance : (n, 4), (n, 4, 4) arrays
        Become the moments of the mixtures; x, y, vx, vy, m and m/s.
    mode_mean, mode_covariance, mode_probability : (n, 2, 4), (n, 2, 4, 4), (n, 2) arrays
        Of the modes; changed in place.
    transition : (2, 2) array
        How probable each mode (column) is after each (row).
    seconds : float
        How far, s.
    calm_density, manoeuvre_density : float
        Power spectral densities of the acceleration in each mode, m²/s³.

    """
    mixed, spread = np.empty((2, 4)), np.empty((2, 4, 4))
    density = calm_density, manoeuvre_density
    for track in range(len(mean)):
        own = mode_probability[track]
        calm, other = own[0], own[1]
        for mode in range(2):
            before = other * transition[1, mode]
            own[mode] = calm * transition[0, mode] + before
            share = before / own[mode] if own[mode] > 0.0 else float(mode)
            _mix(mode_mean[track], mode_covariance[track], share, mixed[mode], spread[mode])
        for mode in range(2):
            moved_on(
                mixed[mode],
                spread[mode],
                seconds,
                density[mode],
                mode_mean[track, mode],
                mode_covariance[track, mode],
            )
        _mix(mode_mean[track], mode_covariance[track], own[1], mean[track], covariance[track])


@inner
def _corrected(
    reference: Floats, mean: Floats, covariance: Floats, reported: Floats,
    weight: Floats, pull: Floats,
) -> float:  # fmt: skip
    """
    Update one state by what was measured (see `gathered`), as seen from a reference.

    Returns 2 log of its likelihood, but for what does not depend on the state: with information T
    and pull g = T (z - x) of the measurements, that is log |P'| - log |P| + g P' g - (z - x) T
    (z - x), where P becomes P'.
    """
    value = 0.0
    for i in range(4):
        pull[i] = reported[9 + i]
    for i in range(4):
        for j in range(4):
            block = 3 * (i // 2 + j // 2) + i % 2 + j % 2
            pull[i] -= reported[block] * (mean[j] - reference[j])
    for i in range(4):
        value += (mean[i] - reference[i]) * (reported[9 + i] + pull[i])
    determinant = invert(covariance, weight)
    add(reported, weight)
    determinant *= invert(weight, covariance)
    for i in range(4):
        step = 0.0
        for j in range(4):
            step += covariance[i, j] * pull[j]
        mean[i] += step
        value += pull[i] * step
    return float(value + np.log(determinant))


@compiled(types.void(*_COLUMNS, FLOATS_2D))
def judge(
    mean: Floats, covariance: Floats, mode_mean: Floats, mode_covariance: Floats,
    mode_probability: Floats, reported: Floats,
) -> None:  # fmt: skip
    """
    Update the modes by what was measured, and judge them by how well they foresaw it.

    Bar-Shalom, Li and Kirubarajan 2001, equations 11.6.6-11 to 11.6.6-16. A pair's likelihood
    counts for as much as the pair is probable, as its information does.

    Parameters
    ----------
    mean, covariance : (n, 4), (n, 4, 4) arrays
        Predicted; become the moments of the mixtures of who was measured.
    mode_mean, mode_covariance, mode_probability : (n, 2, 4), (n, 2, 4, 4), (n, 2) arrays
        Of the modes, predicted; changed in place.
    reported : (n, 13) array
        What was measured, see `gathered`.

    """
    weight, pull, fit = np.empty((4, 4)), np.empty(4), np.empty(2)
    for own in range(len(mean)):
        if reported[own, 0] > 0.0:
            for mode in range(2):
                fit[mode] = _corrected(
                    mean[own],
                    mode_mean[own, mode],
                    mode_covariance[own, mode],
                    reported[own],
                    weight,
                    pull,
                )
            calm, other = mode_probability[own, 0], mode_probability[own, 1]
            other *= np.exp(min((fit[1] - fit[0]) / 2, 700.0))
            if other >= 0.0 and calm + other > 0.0:
                mode_probability[own, 0] = calm / (calm + other)
                mode_probability[own, 1] = other / (calm + other)
            _mix(
                mode_mean[own],
                mode_covariance[own],
                mode_probability[own, 1],
                mean[own],
                covariance[own],
            )
