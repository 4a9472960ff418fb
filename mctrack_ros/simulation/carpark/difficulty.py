"""How hard a recording of the car park is: contrast, fragments, merges."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode, EventCode, Events
from mctrack_ros.simulation.carpark.rendering.render import CarParkView
from mctrack_ros.simulation.carpark.world import CarParkWorld
from mctrack_ros.simulation.difficulty import OCCLUDED_BELOW

_LASTING = 2
"""Images in a row: an object that is found in two is no longer transient (section 4)."""


@dataclass(frozen=True, slots=True)
class CarParkDifficulty:
    """
    Figures of difficulty; people count while they are active, all in the image.

    Attributes
    ----------
    people, bicycles, vehicle_moves : int
        People who are seen, bicycles that ride through, and times that a car comes or leaves.
    contrast : float
        Median difference between a person and what is behind, grey levels.
    fragmented_share : float
        Share of person-images in which an ideal difference mask (T = 12, opened) is in pieces.
    fragmented_people : float
        Share of the people to whom that happens in two images in a row: as many as make a
        fragment an object of its own.
    unseen_share : float
        Share of person-images in which that mask holds no piece of at least 20 px.
    occluded_share : float
        Share of rows with less than 95 % of the pixels visible.
    merges_per_camera_minute : float
        True merges of blobs.

    """

    people: int
    bicycles: int
    vehicle_moves: int
    contrast: float
    fragmented_share: float
    fragmented_people: float
    unseen_share: float
    occluded_share: float
    merges_per_camera_minute: float

    def figures(self) -> dict[str, float]:
        """Return name -> number."""
        return asdict(self)


class CarParkMeter:
    """Count the difficulty of a world while its views are made, camera by camera at each step."""

    def __init__(self, world: CarParkWorld) -> None:
        self._world = world
        self._cameras, count = len(world.cameras), len(world.ids)
        self._images = self._merges = self._rows = self._occluded = 0
        self._seen = np.zeros(count, np.bool_)
        self._in_pieces_for = np.zeros((self._cameras, count), np.int64)
        self._fragmented = np.zeros(count, np.bool_)
        self._contrast: list[float] = []
        self._pieces: list[int] = []

    def add(self, view: CarParkView, events: Events) -> None:
        """Count one image and what happened in it."""
        step, camera = divmod(self._images, self._cameras)
        active = self._world.active[step, view.person]
        self._images += 1
        self._merges += int(np.count_nonzero(events.event == EventCode.MERGE))
        self._rows += int(active.sum())
        self._occluded += int((active & (view.visible < OCCLUDED_BELOW)).sum())
        person = self._world.class_id[view.person] == ClassCode.PERSON
        whole = active & person & ~view.truncated & (view.visible > 0)
        self._contrast += view.contrast[whole].tolist()
        self._pieces += view.pieces[whole].tolist()
        self._count_people(view.person[whole], view.pieces[whole] > 1, camera)

    def _count_people(
        self, index: NDArray[np.int64], is_in_pieces: NDArray[np.bool_], camera: int
    ) -> None:
        """Count who is seen, (n,), and who of them is in pieces for long enough."""
        self._seen[index] = True
        in_pieces = np.zeros_like(self._seen)
        in_pieces[index] = is_in_pieces
        lasting = self._in_pieces_for[camera]
        lasting[:] = np.where(in_pieces, lasting + 1, 0)
        self._fragmented |= lasting >= _LASTING

    def result(self) -> CarParkDifficulty:
        """Return the figures of what was counted."""
        pieces = np.array(self._pieces)
        minutes = self._images * self._world.scenario.period_s / 60
        bicycle = self._world.class_id == ClassCode.BICYCLE
        vehicle = self._world.class_id == ClassCode.VEHICLE
        begins = np.diff(self._world.active[:, vehicle].astype(np.int8), axis=0) > 0
        return CarParkDifficulty(
            people=int(self._seen.sum()),
            bicycles=int(self._world.active[:, bicycle].any(axis=0).sum()),
            vehicle_moves=int(begins.sum()),
            contrast=float(np.median(self._contrast or [np.nan])),
            fragmented_share=float((pieces > 1).sum() / max(len(pieces), 1)),
            fragmented_people=float(self._fragmented.sum() / max(self._seen.sum(), 1)),
            unseen_share=float((pieces == 0).sum() / max(len(pieces), 1)),
            occluded_share=self._occluded / max(self._rows, 1),
            merges_per_camera_minute=self._merges / max(minutes, 1e-9),
        )
