"""The trackers that are compared, by name; all are given the same detections."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mctrack_experiments.papers.covering.code_cost import METHOD, as_in_the_code
from mctrack_experiments.papers.covering.joint_particles import JointParticleTracker
from mctrack_experiments.papers.covering.mean_shift import MeanShiftTracker
from mctrack_experiments.papers.covering.scenes import CoveringScene
from mctrack_experiments.papers.covering.targets import PointTracker, Sight
from mctrack_experiments.real.stored.tracking import fused
from mctrack_ros.config import config_from, of_chosen, values_of
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.association.config import ASSOCIATION

PROPOSED = ('covering_text', 'covering_code')
"""The paper's method with the cost of its text and of its code."""
BY_DISTANCE: Mapping[str, Any] = {
    'method': 'nearest',
    'appearance_weight': 0.0,
}
"""Kalman filter and nearest neighbour: the likeliest by distance alone."""
ASSOCIATED: Mapping[str, Mapping[str, Any]] = {
    **{name: {'method': METHOD} for name in PROPOSED},
    'kf_nn': BY_DISTANCE,
    'weighed_gnn': {'method': 'weighed_gnn'},
    'jpda': {'method': 'jpda'},
}
"""What of the site's association differs; all else of fusion is the same."""
WHOLE: Mapping[str, Callable[[JointConfig], PointTracker]] = {
    'ms_mt': MeanShiftTracker,
    'pf_js': JointParticleTracker,
}
"""Trackers of their own: mean shift, joint particle filter."""
NAMES = (*PROPOSED, 'kf_nn', *WHOLE, 'weighed_gnn', 'jpda')


def run(name: str, scene: CoveringScene, cameras: tuple[str, ...]) -> Trajectories:
    """Return the tracks that one makes of what some cameras of a scene detect."""
    if name in WHOLE:
        return _alone(WHOLE[name](scene.fusion), scene, cameras)
    with as_in_the_code(name == 'covering_code'):
        return fused(scene.stored, config_of(name, scene.fusion), cameras)


def config_of(name: str, fusion: JointConfig) -> JointConfig:
    """Return a site's fusion with another association."""
    values = {**values_of(fusion.association), **ASSOCIATED[name]}
    association = config_from(ASSOCIATION, of_chosen(ASSOCIATION, values))
    return replace(fusion, association=association)


def _alone(tracker: PointTracker, scene: CoveringScene, cameras: tuple[str, ...]) -> Trajectories:
    frame, ids, place = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty((0, 2))]
    for tick in scene.stored.ticks(cameras):
        told, where = tracker.step(Sight.of(tick, scene.fusion), 1 / scene.stored.rate)
        index = int(tick.stamp_ns * scene.stored.rate // 1e9)
        frame.append(np.full(len(told), scene.stored.frame[index]))
        ids.append(told)
        place.append(where)
    return Trajectories(np.concatenate(frame), np.concatenate(ids), np.concatenate(place))
