"""What a recording of the room is made from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mctrack_ros.simulation.scenario import Scenario

EMPTY_STEPS = 40
"""Images before anybody comes in: the paper learns its background from 30 without people."""


@dataclass(frozen=True, slots=True)
class IndoorScenario(Scenario):
    """
    A recording of the room after the likelihood-grid paper (sections 3 and 6).

    Four cameras of 752 x 480 px below the ceiling, or up to eight, see 6 x 4.2 m in 25 images a
    second. The room is empty for 40 images; then people come in, stay close to one another and
    change places for 550.

    Attributes
    ----------
    people : int
        How many, three to six.

    """

    MOST_CAMERAS: ClassVar[int] = 8

    duration_s: float = 23.6
    cameras: int = 4
    width: int = 752
    height: int = 480
    noise: float = 2.0
    distortion: float = -0.05
    step_s: float = 12.0
    people: int = 4

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        super(IndoorScenario, self).__post_init__()
        if not 1 <= self.people <= 6:
            raise ValueError(f'people is {self.people!r}, expected 1 to 6')
