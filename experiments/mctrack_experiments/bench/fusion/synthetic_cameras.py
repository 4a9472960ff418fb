"""What camera nodes would send of a scene: looks, their own ids, groups, ids they were told."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.adapter import camera_names, on_ground, stamp_of
from mctrack_experiments.bench.fusion.toolkit import Scene
from mctrack_ros.interfaces import (
    MEMBERS,
    TEMPLATE_SIZE,
    CameraDetections,
    ClassCode,
    Detections,
    Feedback,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

KITS = 3
PERSONAL = 0.3
"""Share of somebody's colours that are his own and not his kit's, unless told."""

PIXELS = 60.0
"""How many pixels a template counts, unless told."""

MEMORY_S = 0.5
"""A camera that has not seen somebody for longer calls him something new, s."""

KNOWN_WITHIN_M = 1.0
"""So near to a prediction a camera takes a detection for that track."""

FOCAL_PX, CAMERA_HEIGHT_M, PERSON_M = 1000.0, 8.0, (0.6, 1.8)


class SyntheticCameras:
    """
    The camera nodes of a scene.

    Who caused a detection is used for what a camera's own tracker would know (that it is the one
    of the last image, that it is two) and for colours; global ids come by feedback alone.

    Parameters
    ----------
    scene : Scene
        The scene.
    seed : int
        Of the colours.
    kit : (targets,) int array, optional
        Who is dressed alike; unless given, every third.
    personal : float
        Share of somebody's colours that are his own and not his kit's.
    pixels : float
        How many a template counts: the fewer, the more it changes from image to image.

    """

    def __init__(
        self,
        scene: Scene,
        seed: int,
        kit: Indices | None = None,
        personal: float = PERSONAL,
        pixels: float = PIXELS,
    ) -> None:
        self._pixels = pixels
        self._fields, self._scenario = scene.fields, scene.scenario
        self._names = camera_names(scene.scenario)
        self._rng = np.random.default_rng(seed)
        targets = scene.scenario.truth.shape[1]
        kits = self._rng.dirichlet(np.full(TEMPLATE_SIZE, 0.2), KITS)
        own = self._rng.dirichlet(np.full(TEMPLATE_SIZE, 0.2), targets)
        worn = kits[np.arange(targets) % KITS if kit is None else kit]
        self._colours = (1 - personal) * worn + personal * own
        self._local_id = np.zeros((len(self._names), targets), np.int64)
        self._seen = np.full((len(self._names), targets), -np.inf)
        self._last_id = 0

    def messages(self, frame: int, feedback: Feedback) -> list[CameraDetections]:
        """
        Return what the cameras send at a tick.

        Parameters
        ----------
        frame : int
            The tick, each once and in order.
        feedback : Feedback
            The latest that the cameras have.

        """
        known = feedback.places(stamp_of(self._scenario, frame)), feedback.track_id
        return [
            CameraDetections(name, self._seen_by(index, frame, *known))
            for index, name in enumerate(self._names)
        ]

    def _seen_by(
        self, camera: int, frame: int, places: Floats, track_id: NDArray[np.uint32]
    ) -> Detections:
        first, last = self._fields['pointer'][frame * len(self._names) + camera :][:2].tolist()
        field = {name: self._fields[f'detection_{name}'][first:last] for name in _FIELDS}
        position, target = field['position'], field['target']
        is_group = field['other_target'] >= 0
        self._forget(camera, target[is_group], field['other_target'][is_group])
        near = _nearest(position, places, track_id)
        return Detections.build(
            stamp_of(self._scenario, frame),
            position=on_ground(position),
            covariance=field['covariance'],
            box=self._boxes(camera, position),
            template=self._templates(target),
            local_id=self._local_ids(camera, np.where(is_group, -1, target), frame),
            track_id=np.where(is_group, 0, near[:, 0]),
            members=np.pad(near * is_group[:, None], ((0, 0), (0, MEMBERS - 2))),
            member_count=1 + is_group,
            class_id=np.full(len(target), ClassCode.PERSON),
        )

    def _forget(self, camera: int, *merged: Indices) -> None:
        """Call those who are one detection something new when they come apart."""
        for targets in merged:
            self._seen[camera, targets] = -np.inf

    def _local_ids(self, camera: int, target: Indices, frame: int) -> Indices:
        """Return what a camera calls what it sees; 0: clutter."""
        present = target[target >= 0]
        now = frame * self._scenario.tick_s
        new = present[now - self._seen[camera, present] > MEMORY_S]
        self._local_id[camera, new] = self._last_id + 1 + np.arange(len(new))
        self._last_id += len(new)
        self._seen[camera, present] = now
        return np.where(target >= 0, self._local_id[camera, target], 0)

    def _templates(self, target: Indices) -> Floats:
        """Return colours as they are counted in one image; those of clutter are anybody's."""
        colours = self._colours[target] * self._pixels + 1e-3
        counted = self._rng.standard_gamma(colours)
        return np.asarray(counted / counted.sum(axis=1, keepdims=True))

    def _boxes(self, camera: int, position: Floats) -> Floats:
        """Return where people at (n, 2) positions, m, stand in a camera's image, (n, 4) px."""
        offset = position - self._fields['camera_position'][camera]
        distance = np.linalg.norm(offset, axis=1)
        scale = FOCAL_PX / distance
        width, height = PERSON_M[0] * scale, PERSON_M[1] * scale
        left = FOCAL_PX * np.arctan2(offset[:, 1], offset[:, 0]) - width / 2
        return np.column_stack([left, CAMERA_HEIGHT_M * scale - height, width, height])


_FIELDS = ('position', 'covariance', 'target', 'other_target')


def _nearest(position: Floats, places: Floats, track_id: NDArray[Any]) -> Indices:
    """Return the ids, (n, 2), of the two tracks nearest to (n, 2) positions; 0: none is near."""
    gap = np.linalg.norm(position[:, None] - places[None], axis=2)
    gap = np.pad(gap, ((0, 0), (0, 2)), constant_values=np.inf)
    ids = np.pad(track_id.astype(np.int64), (0, 2))
    nearest = np.argsort(gap, axis=1, kind='stable')[:, :2]
    within = np.take_along_axis(gap, nearest, axis=1) < KNOWN_WITHIN_M
    return np.where(within, ids[nearest], 0)
