"""The covering-graph paper's experiments, on the same detections for every tracker."""

from mctrack_experiments.papers.covering.experiment import reproduce_covering

__all__ = ['reproduce_covering']
