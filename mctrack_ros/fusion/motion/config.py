"""Parameters and columns of the motion stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import OneOf, parameter, tag
from mctrack_ros.fusion.columns import PER_MODE, Column, Columns


@dataclass(frozen=True)
class MotionConfig:
    """
    How targets move and how well they are measured; each model has a subclass of its own.

    Attributes
    ----------
    model : str
        Which model it is of.

    """

    model: str
    acceleration_density: float = parameter(
        2.0,
        'Power spectral density of the acceleration; if models interact, where none is known '
        '[m^2/s^3]',
        minimum=1e-4,
        maximum=1000.0,
    )
    sensor_sigma: float = parameter(
        0.2,
        'Error that every detection has beside its own covariance (calibration, feet) [m]',
        minimum=0.001,
        maximum=100.0,
    )
    compare_cameras: bool = parameter(
        True,
        'Correct and weigh down a camera whose detections lie off those of two or more others',
    )


@dataclass(frozen=True)
class ConstantVelocityConfig(MotionConfig):
    """Parameters of `ConstantVelocity`."""

    model: str = tag('constant_velocity')


@dataclass(frozen=True)
class InteractingConfig(MotionConfig):
    """Parameters of `InteractingModels`."""

    model: str = tag('interacting')
    calm_density: float = parameter(
        0.2,
        'Power spectral density of the acceleration of the calm mode [m^2/s^3]',
        minimum=1e-4,
        maximum=1000.0,
    )
    manoeuvre_density: float = parameter(
        4.0,
        'The same of the manoeuvring one [m^2/s^3]',
        minimum=1e-4,
        maximum=1000.0,
    )
    calm_time: float = parameter(
        2.0, 'How long a target is calm in the mean [s]', minimum=0.001, maximum=10000.0
    )
    manoeuvre_time: float = parameter(
        0.7, 'How long a manoeuvre lasts in the mean [s]', minimum=0.001, maximum=10000.0
    )


MOTION: OneOf[MotionConfig] = OneOf(
    'model',
    'constant_velocity',
    'One constant-velocity filter a target, or two that interact: calm and manoeuvring',
    {'constant_velocity': ConstantVelocityConfig, 'interacting': InteractingConfig},
)
"""The choice of how targets move."""


class MotionColumns(Columns):
    """
    The states of the tracks.

    Attributes
    ----------
    mean : (n, 4) array
        x, y, vx, vy; m and m/s.
    covariance : (n, 4, 4) array
    mode_probability : (n, modes) array
        Of each mode of motion, if there are several.
    mode_mean, mode_covariance : (n, modes, 4), (n, modes, 4, 4) arrays
        The state in each mode; the track's own state has the moments of their mixture.

    """

    __slots__ = ()
    mean = Column(np.float64, 4)
    covariance = Column(np.float64, 4, 4)
    mode_probability = Column(np.float64, PER_MODE)
    mode_mean = Column(np.float64, PER_MODE, 4)
    mode_covariance = Column(np.float64, PER_MODE, 4, 4)

    def absorb(self, kept: int, dropped: int) -> None:
        """Take the more certain state."""
        if np.trace(self.covariance[dropped]) < np.trace(self.covariance[kept]):
            for name in ('mean', 'covariance', 'mode_probability', 'mode_mean', 'mode_covariance'):
                getattr(self, name)[kept] = getattr(self, name)[dropped]
