"""New tracks from the detections that no track took."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.looks import measured
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import Detections
from mctrack_ros.tracking.association import mahalanobis
from mctrack_ros.tracking.kalman import inverse

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Leftover:
    """
    What one picture shows that no track explains.

    Attributes
    ----------
    camera : int
        Index of the camera.
    detections : Detections
        Single, usable rows.

    """

    camera: int
    detections: Detections


def new_tracks(
    leftovers: list[Leftover], tick_ns: int, cameras: int, config: FusionConfig
) -> TrackTable:
    """
    Start a track from each cluster of unexplained detections; ids are not yet given.

    Parameters
    ----------
    leftovers : list of Leftover
        In canonical order, at most one a camera.
    tick_ns : int
        The tick's stamp, ns.
    cameras : int
        How many cameras the site has.
    config : FusionConfig
        Parameters.

    """
    if not leftovers:
        return TrackTable.blank(0, cameras)
    parts = [measured(left.detections, config) for left in leftovers]
    position = np.concatenate([part[0] for part in parts])
    noise = np.concatenate([part[1] for part in parts])
    sizes = [len(left.detections) for left in leftovers]
    camera = np.repeat([left.camera for left in leftovers], sizes)
    label = clusters(position, noise, camera, config)
    table = TrackTable.blank(int(label.max(initial=-1)) + 1, cameras)
    mean, covariance = fused(position, noise, label)
    table.mean[:, :2], table.covariance[:, :2, :2] = mean, covariance
    table.covariance[:, [2, 3], [2, 3]] = config.motion.initial_speed_sigma**2
    start = 0
    for left, size in zip(leftovers, sizes):
        _note(table, label[start : start + size], left)
        start += size
    table.first_ns[:] = table.seen_ns[:] = table.kept_ns[:] = tick_ns
    return table


def clusters(
    position: Floats, noise: Floats, camera: NDArray[np.intp], config: FusionConfig
) -> NDArray[np.intp]:
    """
    Join detections of different cameras that may be one target, the nearest pairs first.

    Parameters
    ----------
    position : (m, 2) array
        Ground positions, m.
    noise : (m, 2, 2) array
        Their covariances, m².
    camera : (m,) array
        Which camera saw each.
    config : FusionConfig
        Parameters.

    Returns
    -------
    (m,) array
        Cluster of each detection, numbered by their first member; one a camera at most.

    """
    squared, _ = mahalanobis(position, noise, position, noise)
    gap = np.linalg.norm(position[:, None] - position[None], axis=2)
    near = (squared < config.association.gate) & (gap < config.life.cluster_distance)
    near &= camera[:, None] != camera[None]
    first, second = np.nonzero(np.triu(near, 1))
    order = np.argsort(squared[first, second], kind='stable')
    cluster = list(range(len(position)))
    members = [[row] for row in cluster]
    for one, other in zip(first[order].tolist(), second[order].tolist()):
        keep, drop = sorted((cluster[one], cluster[other]))
        if keep == drop or set(camera[members[keep]]) & set(camera[members[drop]]):
            continue
        for row in members[drop]:
            cluster[row] = keep
        members[keep] += members[drop]
    return np.unique(np.array(cluster, np.intp), return_inverse=True)[1].astype(np.intp)


def fused(position: Floats, noise: Floats, label: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Return the information-weighted means (k, 2) and covariances (k, 2, 2) of clusters."""
    count = int(label.max(initial=-1)) + 1
    weight = inverse(noise)
    information, weighted = np.zeros((count, 2, 2)), np.zeros((count, 2))
    np.add.at(information, label, weight)
    np.add.at(weighted, label, (weight @ position[..., None])[..., 0])
    covariance = inverse(information)
    return (covariance @ weighted[..., None])[..., 0], covariance


def _note(table: TrackTable, rows: NDArray[np.intp], left: Leftover) -> None:
    detections = left.detections
    table.seen_by_ns[rows, left.camera] = detections.stamp_ns
    table.local_id[rows, left.camera] = detections.local_id
    table.cameras[rows] |= np.uint32(1 << left.camera)
    table.class_id[rows] = np.maximum(table.class_id[rows], detections.class_id)
    table.kit[rows] = np.maximum(table.kit[rows], detections.kit)
    bare = ~table.template[rows].any(axis=1)
    table.template[rows[bare]] = detections.template[bare]
