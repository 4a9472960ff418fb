"""Metrics: arrays in, numbers out."""

from mctrack_ros.evaluation.scores import Scores, evaluate_boxes, evaluate_ground
from mctrack_ros.evaluation.switches import Switches, identity_switches, while_isolated
from mctrack_ros.evaluation.timeline import Timeline, ground_timeline
from mctrack_ros.evaluation.trajectories import Trajectories

__all__ = [
    'Scores',
    'Switches',
    'Timeline',
    'Trajectories',
    'evaluate_boxes',
    'evaluate_ground',
    'ground_timeline',
    'identity_switches',
    'while_isolated',
]
