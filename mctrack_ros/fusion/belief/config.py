"""Parameters of belief propagation's fusion."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter, tag
from mctrack_ros.fusion.config import FusionConfig

WEIGHTS = ('evidence', 'corrected', 'printed')


@dataclass(frozen=True)
class BeliefConfig(FusionConfig):
    """Parameters of `BeliefTracker`."""

    tracker: str = tag('belief')
    particles: int = parameter(
        200, 'Particles of a target, on the ground and in each view', minimum=10, maximum=5000
    )
    iterations: int = parameter(
        2,
        'Most rounds of messages in a tick: another one, with new ground particles, while the '
        'effective number of these is below half',
        minimum=1,
        maximum=20,
    )
    weights: str = parameter(
        'evidence',
        "Weights of Algorithm 1: messages of a view's image alone; corrected, which hold its "
        'prediction, too; or as printed, which count the prior twice',
        choices=WEIGHTS,
    )
    outlier_share: float = parameter(
        0.05,
        'Share of the outlier term in the potential: how often a view follows somebody else',
        minimum=0.0,
        maximum=0.99,
    )
    keep_time: float = parameter(
        3.0, 'A target that no view has seen for so long ends [s]', minimum=0.0, maximum=600.0
    )
    start: bool = parameter(
        True, 'Start targets by detections that the joint tracker confirms; false: by boxes alone'
    )
    seed: int = parameter(1, 'Seed of the random numbers', minimum=0)
