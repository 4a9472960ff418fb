"""What is simulated: one frozen record, from which and a seed all else follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True, slots=True)
class Scenario:
    """
    A simulated match; the defaults are ``pitch5`` (event-tracking paper, section 5.3).

    Attributes
    ----------
    seed : int
        The same seed gives the same bytes.
    duration_s : float
        Length, s.
    rate_hz : float
        Images a second.
    cameras : int
        How many of the five cameras.
    width, height : int
        Size of the images, px.
    noise : float
        Standard deviation of the sensor noise, grey levels; never without.
    shadows : bool
        Whether players throw shadows.
    distortion : float
        First radial coefficient of the lenses, on normalised coordinates; 0: pinhole.
    lighting_drift : float
        Amplitude of the slow change of brightness, relative; 0: none.
    light_step : float
        Change of the light on the scene, once and at once, relative; 0: none.
    gain_step : float
        The same of the camera's gain: of light and noise.
    step_s : float
        When either happens, s.
    start_ns : int
        Time at which the first period begins.

    """

    MOST_CAMERAS: ClassVar[int] = 5

    seed: int = 1
    duration_s: float = 120.0
    rate_hz: float = 25.0
    cameras: int = 5
    width: int = 768
    height: int = 576
    noise: float = 2.0
    shadows: bool = False
    distortion: float = 0.0
    lighting_drift: float = 0.0
    light_step: float = 0.0
    gain_step: float = 0.0
    step_s: float = 20.0
    start_ns: int = 1_700_000_000_000_000_000

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        for name in ('duration_s', 'rate_hz', 'width', 'height', 'noise'):
            value = getattr(self, name)
            if not value > 0:
                raise ValueError(f'{name} is {value!r}, expected more than 0')
        for name in ('light_step', 'gain_step'):
            if not getattr(self, name) > -1:
                raise ValueError(f'{name} is {getattr(self, name)!r}, expected more than -1')
        if not 1 <= self.cameras <= self.MOST_CAMERAS:
            raise ValueError(f'cameras is {self.cameras!r}, expected 1 to {self.MOST_CAMERAS}')

    @property
    def steps(self) -> int:
        """Number of periods."""
        return max(round(self.duration_s * self.rate_hz), 1)

    @property
    def period_s(self) -> float:
        """Length of a period, s."""
        return 1 / self.rate_hz

    def stamp_ns(self, step: int) -> int:
        """Return the stamp of an image: the middle of its period."""
        return self.start_ns + round((step + 0.5) * 1e9 / self.rate_hz)
