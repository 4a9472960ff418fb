"""Potential (8), and the messages and beliefs of Algorithm 1, in the log domain."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, compiled
from mctrack_ros.tracking.particles import normalised

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Singles = NDArray[np.float32]

OUTLIER_VARIANCE = (4.0, 4.0, 0.09, 0.04)
"""Of the outlier term about the mean of the ground particles: x, y, height, width, m²."""
LIKELIEST = 2.0
"""Larger log-likelihoods count as this: two alike who overlap look more like him than he does."""
LEAST_DETERMINANT = 1e-6
"""Of the correlation of a place's axes: rounding leaves less, at grazing lines of sight."""
LEAST_LOG = -30.0
"""A log-weight below the largest by more than this is taken for this."""
LEAST = float(np.exp(LEAST_LOG))


class ViewSamples(NamedTuple):
    """
    Particles of targets in a view, on the ground.

    Attributes
    ----------
    target : (k,) int64 array
        Which targets the view says something of: rows of the ground node.
    state : (k, m, 4) array
        x, y, height, width, m.
    information : (k, m, 5) array
        Of x, x and y, y, height, width: how well the image tells these, 1/m².
    log_scale : (k, m) array
        Half the logarithm of its determinant.
    log_likelihood : (k, m) array
        Of the image; minus infinity: the target cannot be so.
    log_prior : (k, m) array
        Log-density of the prediction.
    hidden : float
        Log-likelihood of an image in which the target is hidden.

    """

    target: Ints
    state: Floats
    information: Floats
    log_scale: Floats
    log_likelihood: Floats
    log_prior: Floats
    hidden: float

    @classmethod
    def of(
        cls,
        target: Ints,
        state: Floats,
        place: Floats,
        size: tuple[float, float],
        log: tuple[Floats, Floats],
        hidden: float = -np.inf,
    ) -> ViewSamples:
        """
        Return particles with (k, m, 2, 2) covariances of places and variances of sizes, m².

        ``log`` are the likelihoods and the densities of the prediction.
        """
        xx, xy, yy = place[..., 0, 0], place[..., 0, 1], place[..., 1, 1]
        scale = np.maximum(xx * yy - xy**2, LEAST_DETERMINANT * xx * yy)
        information = np.empty((*scale.shape, 5))
        information[..., 0], information[..., 2] = yy / scale, xx / scale
        information[..., 1] = -xy / scale
        information[..., 3:] = 1 / np.asarray(size)
        log_scale = -np.log(scale * size[0] * size[1]) / 2
        return cls(target, state, information, log_scale, *log, hidden)


class Round(NamedTuple):
    """
    Weights after a round, of t targets.

    Attributes
    ----------
    ground : (t, n) array
        Of the ground particles; each sums to 1.
    views : list of (k, m) arrays
        Of the particles in each view; each sums to 1.
    to_ground : (v, t, n) array
        Logarithms of the messages from the views, up to constants; alike from a silent one.
    to_view : list of (k, m) arrays
        Logarithms of the messages to each view.

    """

    ground: Floats
    views: list[Floats]
    to_ground: Floats
    to_view: list[Floats]


def propagate(
    ground: Floats,
    views: list[ViewSamples],
    outlier: float,
    weights: str = 'evidence',
    prior: Floats | None = None,
) -> Round:
    """
    Run one round of Algorithm 1 on samples of the motion model.

    The graph is a tree, and samples of a view are fixed within a tick: with them and these ground
    samples, one round is exact.

    Parameters
    ----------
    ground : (t, n, 4) array
        Predicted particles: x, y, height, width, m.
    views : list of ViewSamples
        Of the cameras.
    outlier : float
        Share of the outlier term, lambda.
    weights : str
        `WEIGHTS` of fusion. Corrected: a view's message holds its prediction, as its samples are
        drawn from it. Evidence: it is divided by their density, and so holds its image alone; by
        the outlier term it is that of a hidden target. Printed: weights multiply by the density
        that particles are drawn from, and divide the messages by it.
    prior : (t, n) array, optional
        Log-density of the prediction of the ground particles, for the printed weights.

    """
    own = np.zeros(ground.shape[:2]) if prior is None else prior
    inward, kernels = np.zeros((len(views), *own.shape)), []
    for message, view in zip(inward, views):
        kernel, flat = potential(ground[view.target], view, outlier)
        kernels.append(kernel)
        log = view.log_likelihood + (view.log_prior if weights == 'printed' else 0.0)
        if weights == 'evidence':
            sent = _evidence(kernel, outlier * flat, log, view.hidden)
        else:
            sent = np.asarray(kernel @ normalised(log).astype(np.float32)[..., None])[..., 0]
        message[view.target] = _log(sent) - own[view.target]
    total = inward.sum(axis=0) + own
    outward, beliefs = [], []
    for message, view, kernel in zip(inward, views, kernels):
        view_prior = view.log_prior if weights == 'printed' else np.zeros(view.log_prior.shape)
        others = normalised((total - message)[view.target]).astype(np.float32)
        outward.append(_log((others[:, None] @ kernel)[:, 0]) - view_prior)
        beliefs.append(normalised(view.log_likelihood + outward[-1] + view_prior))
    return Round(normalised(total), beliefs, inward, outward)


def _evidence(kernel: Singles, added: Floats, log: Floats, hidden: float) -> Floats:
    """
    Return the mean likelihoods, (k, n), about ground particles, by kernels (k, n, m).

    The part (k, n) that was added to each kernel, the outlier term, counts as hidden.
    """
    log = np.minimum(log, LIKELIEST)
    largest = np.maximum(log.max(axis=1, keepdims=True), hidden)
    likelihood = np.exp(log - largest)
    columns = np.stack([likelihood, np.ones(log.shape)], axis=-1).astype(np.float32)
    seen, density = np.moveaxis(kernel @ columns, -1, 0)
    hidden_share = log.shape[1] * np.exp(hidden - largest) - likelihood.sum(axis=1, keepdims=True)
    return np.asarray((seen + added * hidden_share) / density)


def potential(ground: Floats, view: ViewSamples, outlier: float) -> tuple[Singles, Floats]:
    """
    Return the potential (8), (k, n, m), of particles, and its outlier Gaussian, (k, n).

    Each target has a scale of its own.
    """
    centre = ground.mean(axis=1, keepdims=True)
    variance = np.asarray(OUTLIER_VARIANCE)
    far = (ground - centre) ** 2 @ (-0.5 / variance) - np.log(variance).sum() / 2
    largest = np.maximum(view.log_scale.max(axis=1), far.max(axis=1))[:, None]
    offset = view.log_scale - largest + np.log1p(-outlier)
    flat = np.exp(far - largest)
    kernel: Singles = _kernel(
        ground - centre, view.state - centre, view.information, offset, outlier * flat
    )
    return kernel, flat


def _log(weight: NDArray[np.floating]) -> Floats:
    """Return logarithms, of (k, n), less those of the largest; none is below `LEAST_LOG`."""
    largest = np.maximum(weight.max(axis=1, keepdims=True), np.finfo(np.float32).tiny)
    return np.asarray(np.log(np.maximum(weight / largest, LEAST)), np.float64)


@compiled(types.f4[:, :, ::1](FLOATS_3D, FLOATS_3D, FLOATS_3D, FLOATS_2D, FLOATS_2D))
def _kernel(
    ground: Floats, view: Floats, information: Floats, offset: Floats, added: Floats
) -> Singles:
    """
    Return Gaussians of all pairs, (k, n, m), times the exponential of offsets, plus (k, n).

    The exponential is a power of 2 by the bits of a number and a polynomial, in loops that the
    compiler turns into vector instructions; its relative error is below 3e-5.
    """
    single = np.float32
    targets, many, few = len(ground), ground.shape[1], view.shape[1]
    least = single(2.5 * LEAST_LOG)
    result = np.empty((targets, many, few), np.float32)
    whole = np.empty(few, np.float32)
    bits, rest = whole.view(np.int32), np.empty(few, np.float32)
    round_by, log2e, half = single(12582912.0), single(1.44269504), single(0.5)
    for k in range(targets):
        a, c = ground[k].astype(np.float32), offset[k].astype(np.float32)
        s = view[k].T.copy().astype(np.float32)
        w = information[k].T.copy().astype(np.float32)
        for n in range(many):
            own, plus = result[k, n], single(added[k, n])
            for m in range(few):
                x, y = a[n, 0] - s[0, m], a[n, 1] - s[1, m]
                h, b = a[n, 2] - s[2, m], a[n, 3] - s[3, m]
                q = w[0, m] * x * x + single(2) * w[1, m] * x * y + w[2, m] * y * y
                q += w[3, m] * h * h + w[4, m] * b * b
                power = max(c[m] - half * q, least) * log2e
                whole[m] = power + round_by
                rest[m] = power - (whole[m] - round_by)
            for m in range(few):
                bits[m] = (bits[m] - 0x4B400000 + 127) << 23
            for m in range(few):
                f = rest[m]
                p = single(0.00133336) * f + single(0.00961813)
                p = ((p * f + single(0.05550411)) * f + single(0.24022651)) * f
                own[m] = ((p + single(0.69314718)) * f + single(1)) * whole[m] + plus
    return result
