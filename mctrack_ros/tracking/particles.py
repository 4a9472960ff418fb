"""Particles: random streams, resampling, weights in the log domain, constant velocity."""

from __future__ import annotations

from zlib import crc32

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import FLOATS_3D, compiled

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def stream(seed: int, name: str, stamp_ns: int) -> np.random.Generator:
    """Return the random numbers of one node (a camera's name) at one stamp, ns."""
    return np.random.default_rng([seed, crc32(name.encode()), stamp_ns % 2**64])


def normalised(log_weight: NDArray[np.floating]) -> Floats:
    """Return weights that sum to 1 along the last axis; equal ones where all are zero."""
    log_weight = np.asarray(log_weight, np.float64)
    largest = log_weight.max(axis=-1, keepdims=True)
    known = np.isfinite(largest)
    weight = np.exp(np.where(known, log_weight, 0.0) - np.where(known, largest, 0.0))
    return np.asarray(weight / weight.sum(axis=-1, keepdims=True))


def effective_size(weight: Floats) -> Floats:
    """Return the effective sample size, 1 to n, of (..., n) weights that sum to 1; (...)."""
    return np.asarray(1.0 / (weight**2).sum(axis=-1))


def systematic_rows(weight: Floats, offset: ArrayLike) -> Indices:
    """
    Return which particles are drawn, (..., n), by (..., n) weights that sum to 1.

    As `filterpy.monte_carlo.systematic_resample`, which draws the offset from NumPy's global
    state, and indexes past the end where the weights sum to less than 1 by rounding.

    Parameters
    ----------
    weight : (..., n) array
        Weights.
    offset : (...) array_like
        0 to 1, the same for all of a set: uniformly random.

    """
    count = weight.shape[-1]
    points = (np.arange(count) + np.asarray(offset)[..., None]) / count
    sums = np.cumsum(weight, axis=-1).reshape(-1, count)
    rows = np.empty(sums.shape, np.int64)
    for row, (ends, drawn) in enumerate(zip(sums, points.reshape(-1, count))):
        rows[row] = np.searchsorted(ends, drawn, side='right')
    return np.asarray(np.minimum(rows, count - 1).reshape(weight.shape))


def moved(
    place: Floats, velocity: Floats, seconds: float, density: Floats | float, noise: Floats
) -> tuple[Floats, Floats]:
    """
    Return places and velocities some time later, by white acceleration.

    Parameters
    ----------
    place, velocity : (..., k) array
        Of particles, in any unit.
    seconds : float
        Time, s.
    density : array_like
        Of the acceleration, unit²/s³.
    noise : (2, ..., k) array
        Standard normal.

    """
    first, second = np.sqrt(np.multiply(density, seconds)) * noise
    drift = seconds * (first / 2 + second / np.sqrt(12))
    return place + seconds * velocity + drift, velocity + first


def whitened(place: Floats, velocity: Floats, seconds: float) -> Floats:
    """
    Return the coordinates, (..., 2 k), in which `moved` adds noise of its density alone.

    Parameters
    ----------
    place, velocity : (..., k) array
        Of particles afterwards, or where and how fast they would be without noise.
    seconds : float
        Time, s, above 0.

    """
    drift = (place / seconds - velocity / 2) * np.sqrt(12)
    return np.asarray(np.concatenate([velocity, drift], axis=-1) / np.sqrt(seconds))


def log_mixture(sample: Floats, mean: Floats, variance: Floats) -> Floats:
    """
    Return the log-densities of samples under equal mixtures of Gaussians.

    Parameters
    ----------
    sample : (k, n, d) array
        Samples of k sets.
    mean, variance : (k, m, d) array
        Of the Gaussians of each set, along each axis.

    Returns
    -------
    (k, n) array

    """
    mean, information = np.ascontiguousarray(mean), np.ascontiguousarray(1 / variance)
    log = _log_mixture(np.ascontiguousarray(sample), mean, information)
    return np.asarray(log - np.log(mean.shape[1]) - mean.shape[2] / 2 * np.log(2 * np.pi))


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_3D, FLOATS_3D))
def _log_mixture(sample: Floats, mean: Floats, information: Floats) -> Floats:
    """Return the logarithms of sums of Gaussians without what is the same for all."""
    sets, count, axes = sample.shape
    log = np.empty((sets, count))
    power = np.empty(mean.shape[1], np.float32)
    scale = np.empty(mean.shape[1], np.float32)
    half = np.float32(0.5)
    for k in range(sets):
        own = sample[k].astype(np.float32)
        centre = mean[k].T.copy().astype(np.float32)
        weight = information[k].T.copy().astype(np.float32)
        for m in range(len(power)):
            scale[m] = np.log(information[k, m]).sum() / 2
        for n in range(count):
            power[:] = scale
            for axis in range(axes):
                place = own[n, axis]
                for m in range(len(power)):
                    offset = place - centre[axis, m]
                    power[m] -= half * weight[axis, m] * offset * offset
            largest = power.max()
            total = 0.0
            for m in range(len(power)):
                if power[m] > largest - np.float32(20.0):
                    total += np.exp(power[m] - largest)
            log[k, n] = largest + np.log(total)
    return log
