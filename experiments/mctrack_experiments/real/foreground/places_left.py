"""How fast places that people have left become background again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.datasets.epfl_terrace import AREA, PERIOD_NS
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Foreground
from mctrack_ros.recording import BagReader

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

SPACING_M = 0.5
"""Of the places that are looked at."""
PERSON_M, WIDTH_M = 1.75, 0.6
BESIDE_M = 0.75
"""Who stands nearer to a place is there."""
AFTER_S = {'just_left': (0.5, 5.0), 'left': (20.0, 60.0)}
"""Times since the last person was at a place, s, by the name of the figure."""


def places_left(
    bag: Path, mappings: Mapping[str, GroundMapping], truth: Trajectories, start_ns: int
) -> dict[str, float]:
    """
    Return the share of foreground where people have been, and where nobody has.

    A place is a person's box in one image. It counts where no box of a person overlaps it.

    Parameters
    ----------
    bag : Path
        With the cameras' masks.
    mappings : mapping of str to GroundMapping
        By camera.
    truth : Trajectories
        Who is where at each image.
    start_ns : int
        Stamp of frame 0.

    Returns
    -------
    dict
        Means over boxes and images: ``just_left`` and ``left`` by the time since somebody was
        there, and ``never``: nobody has been there yet.

    """
    ticks = [np.arange(low, high, SPACING_M) for low, high in AREA]
    places = np.stack(np.meshgrid(*ticks), axis=-1).reshape(-1, 2)
    visited = _last_visits(places, truth)
    sums = {name: np.zeros(2) for name in (*AFTER_S, 'never')}
    with BagReader(bag) as reader:
        for camera, mapping in mappings.items():
            boxes = boxes_at(mapping, places)
            for foreground, _ in reader.rows(f'/{camera}/{Foreground.TOPIC}', Foreground):
                frame = (foreground.stamp_ns - start_ns) // PERIOD_NS
                if not foreground.mask.size or frame not in visited:
                    continue
                people = boxes_at(mapping, truth.position[truth.frame == frame])
                free = ~overlap(boxes, people).any(axis=1)
                share = shares(
                    foreground.mask, boxes * foreground.mask.shape[1] / mapping.image_size[0]
                )
                since_s = (frame - visited[frame]) * PERIOD_NS * 1e-9
                groups = {
                    name: (since_s >= low) & (since_s < high)
                    for name, (low, high) in AFTER_S.items()
                } | {'never': np.isinf(since_s)}
                for name, chosen in groups.items():
                    counted = chosen & free & np.isfinite(share)
                    sums[name] += share[counted].sum(), np.count_nonzero(counted)
    return {name: total / count for name, (total, count) in sums.items()}


def _last_visits(places: Floats, truth: Trajectories) -> dict[int, Floats]:
    """Return by frame when somebody was at each place last, as a frame; -inf: never."""
    last, visited = np.full(len(places), -np.inf), {}
    for frame in np.unique(truth.frame):
        people = truth.position[truth.frame == frame]
        near = np.linalg.norm(places[:, None] - people, axis=2).min(axis=1) < BESIDE_M
        last = np.where(near, frame, last)
        visited[int(frame)] = last
    return visited


def boxes_at(mapping: GroundMapping, places: Floats) -> Floats:
    """Return left, top, right and bottom, (n, 4) px, of people who stand at (n, 2) places, m."""
    foot = mapping.image_from_ground(places)
    height, half = mapping.height_px(places, PERSON_M), mapping.width_px(places, WIDTH_M) / 2
    x, y = foot.T
    return np.column_stack([x - half, y - height, x + half, y])


def overlap(one: Floats, other: Floats) -> Mask:
    """Tell which (n, 4) and (m, 4) boxes overlap, (n, m)."""
    apart = (one[:, None, :2] >= other[:, 2:]) | (one[:, None, 2:] <= other[:, :2])
    return np.asarray(~apart.any(axis=2))


def shares(mask: NDArray[np.uint8], boxes: Floats) -> Floats:
    """Return the share of foreground in (n, 4) boxes, px; NaN: one is not whole in the mask."""
    found = np.full(len(boxes), np.nan)
    for index in np.flatnonzero(np.isfinite(boxes).all(axis=1)):
        left, top, right, bottom = np.round(boxes[index]).astype(int)
        inside = 0 <= left < right <= mask.shape[1] and 0 <= top < bottom <= mask.shape[0]
        if inside:
            found[index] = (mask[top:bottom, left:right] > 0).mean()
    return found
