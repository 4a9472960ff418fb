"""Templates, samples and galleries of targets, and how much targets differ from themselves."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled
from mctrack_ros.fusion.config import CORRELATED_S
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Templates = NDArray[np.float32]
TEMPLATES = types.Array(types.f4, 2, 'C', readonly=True)

MEMORY_S = 20.0
"""Time that is remembered of a target's colours, of all cameras together, s."""

USUAL_VARIANCE = 3e-4
"""Of each bin of the mean root of somebody's templates, before it is learned."""

SCATTER_PRIOR_S = 10.0
"""Time by which that counts, s."""

RIDGE = 0.3
"""Share of it that every bin varies by whatever is learned."""

SURE_S = 2.0
"""Galleries of less than so long tell nothing of how much targets vary, s."""

TEMPLATE_S = 8.0
"""Time constant of a template, s: it follows the light, not single images."""

MOST_AT_ONCE = 0.5
"""Share of it that one detection is at most."""


class AppearanceModel:
    """
    How much targets differ from themselves: by light, place, stride.

    The covariance within a target is learned from all of them and divided out (within-class
    covariance normalisation, Hatch and Stolcke 2006).
    """

    def __init__(self) -> None:
        self._scatter = np.zeros((TEMPLATE_SIZE, TEMPLATE_SIZE))
        self._scatter_s = 0.0
        self._whitening: Floats | None = None

    def learn(self, table: TrackTable, row: int) -> None:
        """Mix the sample of a track that is surely itself into its gallery; begin another."""
        known_s, sample_s = table.gallery_s[row], table.sample_s[row]
        own, mean = table.gallery[row], table.sample[row] / sample_s
        if known_s >= SURE_S:
            change = mean - own
            self._scatter += sample_s * np.outer(change, change)
            self._scatter_s += sample_s
            self._whitening = None
        seconds = min(known_s, MEMORY_S) + sample_s
        own += (mean - own) * sample_s / seconds
        table.gallery_s[row] = seconds
        table.sample[row], table.sample_s[row] = 0.0, 0.0

    @property
    def is_trained(self) -> bool:
        """Whether it has been learned how much targets differ from themselves."""
        return self._scatter_s > 0.0

    def distances(self, one: Floats, other: Floats) -> Floats:
        """Return the (n, m) squared distances of roots (n, 48), (m, 48); 1 is usual of one."""
        return np.asarray(cdist(self.whitened(one), self.whitened(other), 'sqeuclidean'))

    def whitened(self, root: Floats) -> Floats:
        """
        Return roots of templates, (..., 48), scaled so that squared distances are of variance 1.

        That is, of two images of one target: the mean over the bins.
        """
        if self._whitening is None:
            self._whitening = np.asarray(np.linalg.cholesky(self._metric()), np.float64)
        return np.asarray(root @ self._whitening)

    def _metric(self) -> Floats:
        total_s = SCATTER_PRIOR_S + self._scatter_s
        usual = USUAL_VARIANCE * (SCATTER_PRIOR_S / total_s + RIDGE)
        within = self._scatter / total_s + usual * np.eye(TEMPLATE_SIZE)
        return np.linalg.inv(within) / TEMPLATE_SIZE


def collect(table: TrackTable, batch: Batch, rows: Indices, columns: Indices) -> None:
    """Add the colours of detections (k,) without overlap to their tracks (k,)."""
    apart = ~batch.is_overlapped[columns]
    rows, columns = rows[apart], columns[apart]
    template = batch.detections.template[columns]
    since_s = (batch.stamp_ns[columns] - table.seen_by_ns[rows, batch.camera[columns]]) / 1e9
    _mix_in(table.template, rows, template, np.minimum(since_s / TEMPLATE_S, MOST_AT_ONCE))
    alone = ~table.in_contact[rows] & template.any(axis=1)
    rows, seconds = rows[alone], np.minimum(since_s[alone], CORRELATED_S)
    root = np.sqrt(np.maximum(template[alone], 0.0))
    np.add.at(table.sample, rows, seconds[:, None] * root)
    np.add.at(table.sample_s, rows, seconds)


def samples(table: TrackTable, rows: Indices) -> Floats:
    """Return the mean roots (k, 48) of tracks' samples; without one, of the template."""
    seconds = table.sample_s[rows, None]
    mean = table.sample[rows] / np.where(seconds > 0.0, seconds, 1.0)
    return np.where(seconds > 0.0, mean, np.sqrt(np.maximum(table.template[rows], 0.0)))


@compiled(types.void(types.Array(types.f4, 2, 'A'), INTS_1D, TEMPLATES, FLOATS_1D))
def _mix_in(template: Templates, rows: Indices, reported: Templates, weight: Floats) -> None:
    """Mix templates (k, 48), one after the other, into rows (k,); the first as it is."""
    for index in range(len(rows)):
        known = template[rows[index]]
        if reported[index].any():
            share = weight[index] if known.any() else 1.0
            for bin in range(len(known)):
                known[bin] += share * (reported[index, bin] - known[bin])
