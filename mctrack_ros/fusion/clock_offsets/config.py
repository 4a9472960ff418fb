"""Parameters of the estimate of the cameras' clocks from moving targets."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter


@dataclass(frozen=True)
class ClocksConfig:
    """How clocks are compared by targets that move in several views."""

    window: float = parameter(
        180.0,
        "The cameras' clocks are compared by who moved in several views for so long; 0: they are "
        'not [s]',
        minimum=0.0,
        maximum=3600.0,
    )
    limit: float = parameter(
        0.02,
        'A clock that is surely ahead or behind by more is a warning [s]',
        minimum=0.0,
        maximum=10.0,
        at_run_time=True,
    )
    correct: bool = parameter(
        False,
        "Take from the cameras' stamps by what their clocks turn out to be ahead, live",
        at_run_time=True,
    )
