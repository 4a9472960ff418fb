"""Runs fusion over stored detections, as the graph would over live ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mctrack_experiments.datasets.stored import StoredScene
from mctrack_ros.config import config_from, nested, of_chosen
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.fusion import JointConfig
from mctrack_ros.replay.drive import drive


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
    return fused(scene, config_from(JointConfig, of_chosen(JointConfig, values)), cameras)


def fused(scene: StoredScene, config: JointConfig, cameras: tuple[str, ...]) -> Trajectories:
    """Do the same with a configuration whose period is the scene's."""
    instants = (ticked.output.tracks for ticked in drive(config, cameras, scene.ticks(cameras)))
    rows = Trajectories.from_tracks(instants, round(1e9 / scene.rate))
    return replace(rows, frame=scene.frame[rows.frame])
