"""The latest look at each track: the colours of the images in which it stands apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.config import LOOK_S
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.reid.gallery import AppearanceSample
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

NOTHING = AppearanceSample(np.zeros(TEMPLATE_SIZE), 0.0)


def look_at(table: TrackTable, batch: Batch, rows: Indices, columns: Indices) -> None:
    """Add the colours of detections (k,) that stand apart to the latest look at tracks (k,)."""
    template = batch.detections.template[columns]
    apart = ~batch.is_overlapped[columns] & ~table.in_contact[rows] & template.any(axis=1)
    rows, columns, template = rows[apart], columns[apart], template[apart]
    since_ns = batch.stamp_ns[columns] - table.seen_by_ns[rows, batch.camera[columns]]
    seconds = np.minimum(since_ns / 1e9, LOOK_S)
    np.add.at(table.look, rows, seconds[:, None] * np.sqrt(np.maximum(template, 0.0)))
    np.add.at(table.look_s, rows, seconds)


def sample_of(table: TrackTable, row: int) -> AppearanceSample:
    """Return the latest look at a track."""
    seconds = float(table.look_s[row])
    return AppearanceSample(table.look[row] / seconds, seconds) if seconds else NOTHING


def first_sample(table: TrackTable, row: int) -> Floats:
    """Return the mean root of a track's templates, or of the only one there is."""
    look = sample_of(table, row)
    return look.mean if look.seconds else np.sqrt(np.maximum(table.template[row], 0.0))
