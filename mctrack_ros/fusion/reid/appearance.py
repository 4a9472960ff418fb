"""Templates, samples and galleries of targets."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled
from mctrack_ros.fusion.config import LOOK_S
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Templates = NDArray[np.float32]
TEMPLATES = types.Array(types.f4, 2, 'C', readonly=True)

MEMORY_S = 20.0
"""Time that is remembered of a target's colours, of all cameras together, s."""

VARIANCE = 3.9e-4
"""Of each bin of the mean root of somebody's templates: light, place, stride."""

TEMPLATE_S = 8.0
"""Time constant of a template, s: it follows the light, not single images."""

MOST_AT_ONCE = 0.5
"""Share of it that one detection is at most."""


def learn(table: TrackTable, row: int) -> None:
    """Mix the sample of a track that is surely itself into its gallery; begin another."""
    sample_s, own = table.sample_s[row], table.gallery[row]
    seconds = min(table.gallery_s[row], MEMORY_S) + sample_s
    own += (table.sample[row] / sample_s - own) * sample_s / seconds
    table.gallery_s[row] = seconds
    table.sample[row], table.sample_s[row] = 0.0, 0.0


def distances(one: Floats, other: Floats) -> Floats:
    """Return the (n, m) squared distances of roots (n, 48), (m, 48); 1 is usual of one."""
    return np.asarray(cdist(one, other, 'sqeuclidean')) / (TEMPLATE_SIZE * VARIANCE)


def collect(table: TrackTable, batch: Batch, rows: Indices, columns: Indices) -> None:
    """Add the colours of detections (k,) without overlap to their tracks (k,)."""
    apart = ~batch.is_overlapped[columns]
    rows, columns = rows[apart], columns[apart]
    template = batch.detections.template[columns]
    since_s = (batch.stamp_ns[columns] - table.seen_by_ns[rows, batch.camera[columns]]) / 1e9
    _mix_in(table.template, rows, template, np.minimum(since_s / TEMPLATE_S, MOST_AT_ONCE))
    alone = ~table.in_contact[rows] & template.any(axis=1)
    rows, seconds = rows[alone], np.minimum(since_s[alone], LOOK_S)
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
