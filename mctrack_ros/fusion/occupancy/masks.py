"""The last mask of each camera, whether it is worth anything, and who explains all of them."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.fusion.occupancy.solver import Occupancy, solve
from mctrack_ros.fusion.occupancy.vehicle_scene import VehicleScene
from mctrack_ros.interfaces import CameraRows, Foreground, starts_anew

Floats = NDArray[np.float64]

OLDEST_NS = 300_000_000
"""The last mask of a camera counts for so long, ns: of one that is slower than others."""
MOST_FOREGROUND = 0.6
"""Share of a mask above which its camera is dazzled and left out."""
FROZEN_NS = 5_000_000_000
"""For how long a mask with foreground may be the same to the pixel, ns."""
PRIOR_GAIN, PRIOR_SIGMA_M = 0.03, 0.3
"""What a predicted track adds to the gain of a person there, and how far from it, m."""

FARTHEST_SIGMAS = 8.0
"""From where it adds nothing that a double would hold beside a gain."""


class Unusable(StrEnum):
    """Why a camera's mask is left out."""

    SILENT = f'it sent no mask for {OLDEST_NS * 1e-9:g} s'
    UNKNOWN = 'it does not know its background, or has moved'
    DAZZLED = f'more than {MOST_FOREGROUND:.0%} of its image is foreground'
    FROZEN = f'its mask has not changed for {FROZEN_NS * 1e-9:g} s'


class Masks:
    """
    The masks of a site's cameras.

    Parameters
    ----------
    cameras : tuple of str
        Names in the site's order.
    scene : Scene or VehicleScene
        What people, or vehicles, cover in the masks.
    cost : float
        Share of the masks that each must explain.

    """

    def __init__(self, cameras: tuple[str, ...], scene: Scene | VehicleScene, cost: float) -> None:
        self._cameras, self._scene, self._cost = cameras, scene, cost
        self._last: dict[str, Foreground] = {}
        self._changed_ns: dict[str, int] = {}
        self._stamp_ns: int | None = None

    def take(self, received: list[CameraRows[Foreground]], stamp_ns: int) -> None:
        """Keep the masks of a tick, and when they changed last."""
        last_ns, self._stamp_ns = self._stamp_ns, stamp_ns
        if starts_anew(stamp_ns, last_ns):
            self._last, self._changed_ns = {}, {}
        for message in received:
            if message.camera not in self._cameras:
                known = list(self._cameras)
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
            new, old = message.rows, self._last.get(message.camera)
            self._last[message.camera] = new
            if old is None or not len(new) or not np.array_equal(old.mask, new.mask):
                self._changed_ns[message.camera] = new.stamp_ns

    def left_out(self, stamp_ns: int) -> dict[str, Unusable]:
        """Tell whose masks are worth nothing, and why."""
        left_out = {}
        for camera in self._cameras:
            last = self._last.get(camera)
            if last is None or stamp_ns - last.stamp_ns > OLDEST_NS:
                left_out[camera] = Unusable.SILENT
            elif not last.mask.size:
                left_out[camera] = Unusable.UNKNOWN
            elif len(last) > MOST_FOREGROUND * last.mask.size:
                left_out[camera] = Unusable.DAZZLED
            elif stamp_ns - self._changed_ns[camera] > FROZEN_NS:
                left_out[camera] = Unusable.FROZEN
        return left_out

    def explained(self, left_out: dict[str, Unusable], prior: Floats, stamp_ns: int) -> Occupancy:
        """Return the people that explain the masks, given what is added to the gain of cells."""
        none = Foreground.build(stamp_ns)
        masks = tuple(self._last.get(camera, none).mask for camera in self._cameras)
        shapes = tuple((mask.shape[0], mask.shape[1]) for mask in masks)
        used = np.array([camera not in left_out for camera in self._cameras])
        return solve(masks, self._scene.places(shapes), prior, used, self._cost)


def prior_of(places: Floats, position: Floats) -> Floats:
    """
    Return what tracks predicted at places, (k, 2) m, add to the gain of cells at (n, 2) m.

    Of the cells y ascends.
    """
    prior, reach = np.zeros(len(position)), FARTHEST_SIGMAS * PRIOR_SIGMA_M
    for place in places:
        rows = slice(*np.searchsorted(position[:, 1], (place[1] - reach, place[1] + reach)))
        squared = ((position[rows] - place) ** 2).sum(axis=1) / PRIOR_SIGMA_M**2
        prior[rows] = np.maximum(prior[rows], PRIOR_GAIN * np.exp(-squared / 2))
    return prior
