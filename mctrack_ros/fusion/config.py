"""Every parameter of fusion: names, units, ranges, defaults."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import OneOf, parameter, tag
from mctrack_ros.fusion.association.solvers import ASSOCIATORS

MISSED_IMAGES = 2.5
"""A camera from which nothing came for so many of its intervals has lost two images, not one."""
LOOK_S = 0.25
"""Images of one camera within this time count as one look, s: so long errors of feet last."""


@dataclass(frozen=True)
class BatchingConfig:
    """When a tick is closed."""

    period: float = parameter(
        0.04, 'Length of a tick, that of the fastest camera [s]', minimum=0.001, maximum=10.0
    )
    max_wait: float = parameter(
        0.8,
        'Longest wait for a camera after the first arrival [periods]',
        minimum=0.0,
        maximum=100.0,
    )
    camera_timeout: float = parameter(
        1.0,
        'A camera silent for so long, and for 2.5 periods, is not waited for [s]',
        minimum=0.01,
        maximum=600.0,
    )
    time_sync_limit: float = parameter(
        0.2,
        "Cameras' clocks may differ by so much, which is removed; one that is ahead by more is "
        'left out; 0: clocks are not compared [s]',
        minimum=0.0,
        maximum=60.0,
    )

    @property
    def patience(self) -> float:
        """For how long a camera may be silent and still counts as live, s."""
        return max(self.camera_timeout, MISSED_IMAGES * self.period)


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


@dataclass(frozen=True)
class AssociationConfig:
    """
    Which detection belongs to which track; the methods have subclasses of their own.

    Attributes
    ----------
    method : str
        Which method it is of.

    """

    method: str
    gate: float = parameter(
        13.8, 'Largest squared Mahalanobis distance of a pair', minimum=0.1, maximum=1000.0
    )
    appearance_weight: float = parameter(
        12.0,
        'What the squared Hellinger distance of two templates costs, beyond the usual [-2 log]',
        minimum=0.0,
        maximum=1000.0,
    )
    usual_difference: float = parameter(
        0.15,
        'Squared Hellinger distance of two templates that speaks neither for nor against',
        minimum=0.0,
        maximum=1.0,
    )


@dataclass(frozen=True)
class JointAssociationConfig(AssociationConfig):
    """Parameters of `JointAssociation`."""

    method: str = tag(*(name for name in ASSOCIATORS if name != 'covering_graph'))
    false_density: float = parameter(
        0.002,
        'Detections that belong to no known target, per camera and image [1/m^2]',
        minimum=1e-9,
        maximum=100.0,
    )
    identity_bonus: float = parameter(
        1.0,
        'What a pair gains if the camera believes it is the same target [-2 log]',
        minimum=0.0,
        maximum=100.0,
    )


@dataclass(frozen=True)
class CoveringConfig(AssociationConfig):
    """Parameters of `CoveringAssociation`."""

    method: str = tag('covering_graph')


ASSOCIATION: OneOf[AssociationConfig] = OneOf(
    'method',
    'weighed_gnn',
    'How pairs compete',
    {
        name: CoveringConfig if name == 'covering_graph' else JointAssociationConfig
        for name in ASSOCIATORS
    },
)
"""The choice of how pairs compete."""


@dataclass(frozen=True)
class LifeConfig:
    """When a track begins and ends."""

    hit_evidence: float = parameter(
        2.0,
        'What a detection adds to the log-odds of a track, per look',
        minimum=0.0,
        maximum=100.0,
    )
    confirm_evidence: float = parameter(
        4.0, 'Log-odds that confirm a track', minimum=0.0, maximum=100.0
    )
    coverage_prior: float = parameter(
        0.7,
        'Probability that a camera detects what stands where nothing is known yet',
        minimum=0.0,
        maximum=0.99,
    )
    coverage_cell: float = parameter(
        2.0, 'Edge of a cell of the learned coverage [m]', minimum=0.01, maximum=1000.0
    )
    tentative_time: float = parameter(
        0.15, 'A tentative track without support for so long ends [s]', minimum=0.0, maximum=100.0
    )
    report_time: float = parameter(
        0.5,
        'A track without support is published for so long at most [s]',
        minimum=0.0,
        maximum=100.0,
    )
    coast_time: float = parameter(
        1.0, 'A track without support is kept for so long [s]', minimum=0.0, maximum=1000.0
    )
    most_tracks: int = parameter(
        2000, 'So many tracks are kept at a time; no more begin', minimum=1, maximum=100000
    )
    merge_distance: float = parameter(
        1.0,
        'Two tracks that cameras hardly tell apart become one when nearer than this [m]',
        minimum=0.0,
        maximum=100.0,
    )


@dataclass(frozen=True)
class ReidConfig:
    """Who is who after an encounter."""

    contact_distance: float = parameter(
        1.5, 'Who is nearer to another may leave as that one [m]', minimum=0.0, maximum=100.0
    )
    lost_time: float = parameter(
        20.0, 'For how long one who was lost may be found again [s]', minimum=0.0, maximum=10000.0
    )


@dataclass(frozen=True)
class FusionConfig:
    """
    Parameters of fusion; each tracker has a subclass of its own.

    Attributes
    ----------
    tracker : str
        Which tracker they are of.

    """

    tracker: str
    batching: BatchingConfig = BatchingConfig()


@dataclass(frozen=True)
class JointConfig(FusionConfig):
    """Parameters of `JointTracker`."""

    tracker: str = tag('joint')
    motion: MotionConfig = MOTION.field()
    association: AssociationConfig = ASSOCIATION.field()
    life: LifeConfig = LifeConfig()
    recognition: ReidConfig = ReidConfig()
