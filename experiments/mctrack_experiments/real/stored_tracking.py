"""Runs fusion over stored detections, as the graph would over live ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mctrack_experiments.datasets.stored import StoredScene
from mctrack_ros.config import config_from, nested, of_chosen
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.fusion import FusionPipeline, JointConfig, open_batcher
from mctrack_ros.interfaces import Tick


def track_stored(
    scene: StoredScene, settings: Mapping[str, Any], cameras: tuple[str, ...] | None = None
) -> Trajectories:
    """
    Fuse the detections of some cameras.

    Parameters
    ----------
    scene : StoredScene
        Its truth is not looked at.
    settings : dict
        What differs from the default `JointConfig`, by dotted name; the period is set.
    cameras : tuple of str, optional
        Which cameras; left out: all.

    Returns
    -------
    Trajectories
        Published, confirmed tracks, numbered with the scene's frames.

    """
    cameras = scene.cameras if cameras is None else cameras
    values = nested({'batching.period': 1 / scene.rate, **settings})
    config = config_from(JointConfig, of_chosen(JointConfig, values))
    pipeline = FusionPipeline(config, cameras)
    outputs = [pipeline.step(tick).tracks for tick in ticks(scene, config, cameras)]
    rows = Trajectories.from_tracks(outputs, round(1e9 / scene.rate))
    return Trajectories(frame=scene.frame[rows.frame], id=rows.id, position=rows.position)


def ticks(scene: StoredScene, config: JointConfig, cameras: tuple[str, ...]) -> Iterator[Tick]:
    """Yield the scene's ticks; every message arrives when its image is taken."""
    batcher = open_batcher(config, cameras)
    for index in range(len(scene.frame)):
        for camera in cameras:
            detections = scene.detections[camera][index]
            yield from batcher.add(camera, detections, detections.stamp_ns)
    yield from batcher.flush()
