"""Metrics: arrays in, numbers out."""

from mctrack_ros.evaluation.scores import Scores, evaluate_boxes, evaluate_ground
from mctrack_ros.evaluation.trajectories import Trajectories

__all__ = ['Scores', 'Trajectories', 'evaluate_boxes', 'evaluate_ground']
