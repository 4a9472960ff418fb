"""Parameters of the likelihood-grid paper's fusion."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter, tag
from mctrack_ros.fusion.config import FusionConfig

LAYERS = ('both', 'edges')


@dataclass(frozen=True)
class TargetsConfig:
    """When tracks begin and end (Algorithm 1)."""

    gate: float = parameter(
        0.9, 'Radius around a predicted target in which it is measured [m]', minimum=0.01
    )
    confirm_time: float = parameter(
        0.2, 'A target that has been detected for so long is published [s]', minimum=0.0
    )
    keep_time: float = parameter(
        0.6,
        'A target is kept for as long as it was detected before, and so long at most; the paper: '
        '0.4 [s]',
        minimum=0.0,
    )


@dataclass(frozen=True)
class LikelihoodGridConfig(FusionConfig):
    """Parameters of `LikelihoodGridTracker`."""

    tracker: str = tag('likelihood_grid')
    layers: str = parameter(
        'both',
        'What people are found by: edges alone, as the paper, or edges and foreground masks',
        choices=LAYERS,
    )
    least_likelihood: float = parameter(
        -3.0,
        'Mean log-likelihood of the cameras from which a maximum of edges alone is a person',
        minimum=-4.5,
        maximum=0.0,
    )
    person_width: float = parameter(
        0.45, 'Width of a person in the masks [m]', minimum=0.05, maximum=10.0
    )
    targets: TargetsConfig = TargetsConfig()
