"""What a recording of the car park is made from."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.simulation.scenario import Scenario


@dataclass(frozen=True, slots=True)
class CarParkScenario(Scenario):
    """
    A recording of the car park after the silhouettes paper's conditions (sections 2, 5 and 6).

    One monochrome camera of 640 x 480 px and low contrast, sampled at 4 Hz. In ten minutes goes on
    what a car park sees in two to three hours. The light changes slowly by the amplitude
    ``lighting_drift``; ``shadows`` and ``noise`` are as for the pitch.

    Attributes
    ----------
    bicycles : bool
        Whether people ride through on bicycles, too; the paper has none.

    """

    duration_s: float = 600.0
    rate_hz: float = 4.0
    cameras: int = 1
    width: int = 640
    height: int = 480
    noise: float = 2.6
    shadows: bool = True
    lighting_drift: float = 0.06
    bicycles: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        super(CarParkScenario, self).__post_init__()
        if self.cameras != 1:
            raise ValueError(f'cameras is {self.cameras!r}, expected 1: the car park has one')
