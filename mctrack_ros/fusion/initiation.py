"""New tracks from the detections that no track took."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.matching import note
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.association import mahalanobis
from mctrack_ros.tracking.kalman import inverse

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def new_tracks(
    looks: Looks, rows: Indices, tick_ns: int, cameras: int, config: FusionConfig
) -> TrackTable:
    """
    Start a track from each cluster of unexplained detections; ids are not yet given.

    Parameters
    ----------
    looks : Looks
        The pictures of the tick.
    rows : (k,) int array
        Detections that no track explains, of one picture a camera at most.
    tick_ns : int
        The tick's stamp, ns.
    cameras : int
        How many cameras the site has.
    config : FusionConfig
        Parameters.

    """
    position, noise = looks.position[rows], looks.noise[rows]
    label = clusters(position, noise, looks.camera[rows], config)
    table = TrackTable.blank(int(label.max()) + 1, cameras)
    mean, covariance = fused(position, noise, label)
    table.mean[:, :2], table.covariance[:, :2, :2] = mean, covariance
    table.covariance[:, [2, 3], [2, 3]] = config.motion.initial_speed_sigma**2
    note(table, looks, label, rows)
    template = looks.detections.template[rows]
    told = np.flatnonzero(template.any(axis=1))[::-1]
    table.template[label[told]] = template[told]  # the first one's stays
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
