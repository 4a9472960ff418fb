"""The likelihood-grid paper on its indoor scene, and on the real terrace."""

from mctrack_experiments.papers.likelihood_grid.experiment import reproduce_grid

__all__ = ['reproduce_grid']
