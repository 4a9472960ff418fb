"""Where several cameras see one target at the same instants."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BLOCK_S = 5.0
"""Instants of so long a time are compared together, s."""
INSTANT_S = 0.2
"""Time between instants, s: errors of feet last longer."""
INSTANTS = round(BLOCK_S / INSTANT_S)
PLACE_S = 0.1
"""A place is told from what is seen so long before and after, s: at least by two images."""
SIDE = 2
"""A velocity is the slope of the places at an instant and so many before and after."""
GAP_S, GAP_INTERVALS, LONGEST_GAP_S = 0.25, 2.5, 1.0
"""Over a longer gap nothing is interpolated: s, or in the camera's images, and at most, s."""
MARGIN_S = 2.0
"""What is needed before and after a block, s."""
LEAST = 3
"""Instants of a block that cameras have in common, at least."""


@dataclass(frozen=True, eq=False, slots=True)
class Moments:
    """
    What the same n cameras say of targets in s blocks of m instants.

    Attributes
    ----------
    target, block : (s,) int arrays
        Whom, and in which block of time.
    is_known : (s, m) bool array
        At which instants all of them see the target; the rest is filled with something.
    place : (s, m, n, 2) array
        Where each sees it, m.
    information : (s, m, n, 2, 2) array
        How well it says it knows, 1/m².
    part : (s, m, n, 2) array
        What each adds to the target's velocity, by how well it knows it: the sum is that, m/s.
    rest : (s, m, n, 2) array
        The velocity as the other cameras show it, m/s.

    """

    target: Indices
    block: Indices
    is_known: NDArray[np.bool_]
    place: Floats
    information: Floats
    part: Floats
    rest: Floats

    @property
    def velocity(self) -> Floats:
        """Return the (s, m, 2) velocities of the targets, m/s."""
        return np.asarray(self.part.sum(axis=2))


BySet = Mapping[tuple[int, ...], Moments]
"""By the cameras, in ascending order."""


def joined(parts: Iterable[BySet]) -> BySet:
    """Return the blocks of several times together."""
    found: dict[tuple[int, ...], list[Moments]] = defaultdict(list)
    for part in parts:
        for cameras, moments in part.items():
            found[cameras].append(moments)
    names = [field.name for field in fields(Moments)]
    return {
        cameras: Moments(*(np.concatenate([getattr(one, name) for one in own]) for name in names))
        for cameras, own in found.items()
    }


def moments_of(sightings: NDArray[np.void], block: int) -> BySet:
    """
    Bring the sightings of a block to common instants.

    Parameters
    ----------
    sightings : (n,) array of `SIGHTING`
        From `MARGIN_S` before the block to as long after it, in any order; times are corrected by
        what is known of the clocks.
    block : int
        Its number.

    """
    instants: Floats = block * BLOCK_S + INSTANT_S * np.arange(-SIDE, INSTANTS + SIDE, dtype=float)
    order = np.lexsort((sightings['seconds'], sightings['camera'], sightings['track']))
    ordered = sightings[order]
    found: dict[tuple[int, ...], list[Moments]] = defaultdict(list)
    for target in _split(ordered, 'track'):
        views = {
            int(one['camera'][0]): _View.of(one, instants) for one in _split(target, 'camera')
        }
        views = {camera: view for camera, view in views.items() if view.is_known.any()}
        if len(views) > 1:
            for cameras, moments in _of_target(int(target['track'][0]), block, views):
                found[cameras].append(moments)
    return joined({cameras: one} for cameras, own in found.items() for one in own)


def _split(ordered: NDArray[np.void], name: str) -> list[NDArray[np.void]]:
    bounds = np.flatnonzero(np.diff(ordered[name])) + 1
    return list(np.split(ordered, bounds)) if len(ordered) else []


def _of_target(
    target: int, block: int, views: Mapping[int, _View]
) -> Iterable[tuple[tuple[int, ...], Moments]]:
    """Yield what each set of cameras says of a target, at instants when no other does."""
    names = np.array(list(views))
    known = np.stack([view.is_known for view in views.values()])
    for pattern in np.unique(known.T, axis=0):
        at = (known == pattern[:, None]).all(axis=0)
        if pattern.sum() < 2 or at.sum() < LEAST:
            continue
        cameras = tuple(names[pattern].tolist())
        own = [views[camera] for camera in cameras]
        place, information, velocity = (
            np.stack([getattr(view, name) for view in own], axis=1)[None]
            for name in ('place', 'information', 'velocity')
        )
        total = information.sum(axis=2)
        pull = np.einsum('smnij,smnj->smni', information, velocity)
        part = np.linalg.solve(total[:, :, None], pull[..., None])[..., 0]
        others = pull.sum(axis=2, keepdims=True) - pull
        rest = np.linalg.solve(total[:, :, None] - information, others[..., None])[..., 0]
        yield (
            cameras,
            Moments(
                np.array([target]), np.array([block]), at[None], place, information, part, rest
            ),
        )


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """
    What one camera says of a target at m instants; where it says nothing, something harmless.

    Attributes
    ----------
    is_known : (m,) bool array
        Whether it says anything.
    place, information : (m, 2), (m, 2, 2) arrays
        Where the target is, m, and how well that is known, 1/m².
    velocity : (m, 2) array
        The slope of the places around, m/s.

    """

    is_known: NDArray[np.bool_]
    place: Floats
    information: Floats
    velocity: Floats

    @classmethod
    def of(cls, sightings: NDArray[np.void], instants: Floats) -> _View:
        """
        Take the sightings to instants, of which `SIDE` at either end are for velocities alone.

        The error of a velocity is as much like that of places before as of places after, whatever
        the camera's rate, so it does not depend on that of the place at its own instant.
        """
        seconds, place, noise = (
            np.ascontiguousarray(sightings[name]) for name in ('seconds', 'place', 'covariance')
        )
        inner, count = slice(SIDE, -SIDE), len(seconds)
        if count < 2:
            shape = len(instants[inner]), 2
            unit: Floats = np.broadcast_to(np.eye(2), (*shape, 2))
            return cls(np.zeros(shape[0], bool), np.zeros(shape), unit, np.zeros(shape))
        after = np.clip(np.searchsorted(seconds, instants, 'right'), 1, count - 1)
        before = after - 1
        gap = seconds[after] - seconds[before]
        usual = GAP_INTERVALS * float(np.median(np.diff(seconds)))
        known = (gap > 0) & (gap <= np.clip(usual, GAP_S, LONGEST_GAP_S))
        known &= (instants >= seconds[before]) & (instants <= seconds[after])
        shown = _placed(seconds, place, instants, after)
        velocity, is_known, total = np.zeros_like(shown[inner]), known[inner], 0
        for step in range(1, SIDE + 1):
            later, earlier = (np.roll(shown, sign * step, axis=0)[inner] for sign in (-1, 1))
            velocity += step * (later - earlier)
            is_known = is_known & np.roll(known, step)[inner] & np.roll(known, -step)[inner]
            total += 2 * step**2
        information = np.linalg.inv(noise[before[inner]])
        return cls(is_known, shown[inner], information, velocity / (total * INSTANT_S))


def _placed(seconds: Floats, place: Floats, instants: Floats, after: Indices) -> Floats:
    """
    Return the (m, 2) places at instants by lines fitted to what lies around, m.

    That is what lies within `PLACE_S`, as many before as after, or the two beside the instant.
    """
    time, away = (seconds - seconds[0])[:, None], place - place[0]
    columns = np.hstack([time, time**2, away, time * away])
    total = np.concatenate([np.zeros((1, 6)), np.cumsum(columns, axis=0)])
    low = np.searchsorted(seconds, instants - PLACE_S)
    high = np.searchsorted(seconds, instants + PLACE_S, 'right')
    reach = np.clip(np.minimum(after - low, high - after), 1, None)
    first, last = np.maximum(after - reach, 0), np.minimum(after + reach, len(seconds))
    sums, count = total[last] - total[first], (last - first)[:, None]
    spread = np.maximum(sums[:, 1:2] - sums[:, 0:1] ** 2 / count, 1e-6)
    slope = (sums[:, 4:6] - sums[:, 0:1] * sums[:, 2:4] / count) / spread
    later = (instants - seconds[0])[:, None] - sums[:, 0:1] / count
    return np.asarray(place[0] + sums[:, 2:4] / count + slope * later)
