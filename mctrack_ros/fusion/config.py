"""Every parameter of fusion: names, units, ranges, defaults."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import OneOf, parameter, tag
from mctrack_ros.fusion.association.solvers import ASSOCIATORS

MISSED_IMAGES = 2.5
"""A camera from which nothing came for so many of its intervals has lost two images, not one."""


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
    initial_speed_sigma: float = parameter(
        2.0,
        'Standard deviation of the velocity of a new target [m/s]',
        minimum=0.01,
        maximum=100.0,
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
    tentative_cost: float = parameter(
        4.0, 'What a track that is not confirmed costs more [-2 log]', minimum=0.0, maximum=100.0
    )
    identity_bonus: float = parameter(
        1.0,
        'What a pair gains if the camera believes it is the same target [-2 log]',
        minimum=0.0,
        maximum=100.0,
    )
    likeness_weight: float = parameter(
        0.0,
        'What looking less like a detection than another track near by costs, per logarithm of '
        'the differences, in variances of one [-2 log]',
        minimum=0.0,
        maximum=1000.0,
    )
    overlap_trust: float = parameter(
        0.3,
        'Share of the identity bonus that is left where boxes overlap in the image',
        minimum=0.0,
        maximum=1.0,
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

    cluster_distance: float = parameter(
        1.5,
        'Unassigned detections of two cameras farther apart start no common track [m]',
        minimum=0.01,
        maximum=100.0,
    )
    look_time: float = parameter(
        0.25,
        'Images of one camera within this time count as one look [s]',
        minimum=0.001,
        maximum=100.0,
    )
    hit_evidence: float = parameter(
        2.0,
        'What a detection adds to the log-odds of a track, per look',
        minimum=0.0,
        maximum=100.0,
    )
    miss_weight: float = parameter(
        0.8,
        'How much a miss counts for a confirmed track, which may be hidden for a while',
        minimum=0.0,
        maximum=1.0,
    )
    vacancy_weight: float = parameter(
        2.0,
        'How much it counts, likewise, that a camera sees bare ground where a track is expected',
        minimum=0.0,
        maximum=10.0,
    )
    vacancy_distance: float = parameter(
        0.5,
        'What is less certain than this of its place is not expected anywhere [m]',
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
    crowd_distance: float = parameter(
        1.0,
        'What begins so near to a confirmed track is at first taken for a part of it [m]',
        minimum=0.0,
        maximum=100.0,
    )
    crowd_evidence: float = parameter(
        4.0, 'Log-odds that it lacks then', minimum=0.0, maximum=100.0
    )
    most_evidence: float = parameter(
        8.0, 'Log-odds are counted no further than this', minimum=0.0, maximum=1000.0
    )
    least_evidence: float = parameter(
        0.0,
        'Misses take the log-odds of a track that is not confirmed no lower, so that what comes '
        'into view late is confirmed as fast as any other',
        minimum=-1000.0,
        maximum=0.0,
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
    gone_evidence: float = parameter(
        5.0,
        'What no camera sees, where they usually do see who is there, is published no longer from '
        'these log-odds on that it has gone; never, if this is above most_evidence',
        minimum=0.001,
        maximum=1000.0,
    )
    coast_time: float = parameter(
        1.0, 'A track without support is kept for so long [s]', minimum=0.0, maximum=1000.0
    )
    hidden_time: float = parameter(
        1.0,
        'A track is kept for so long by its group alone, if others of it are seen [s]',
        minimum=0.0,
        maximum=1000.0,
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
    merge_time: float = parameter(
        1.7,
        'How long in one place; farther apart it takes longer, and sooner if neither is confirmed '
        '[s]',
        minimum=0.0,
        maximum=100.0,
    )
    template_time: float = parameter(
        8.0, 'Time constant of the appearance template [s]', minimum=0.01, maximum=1000.0
    )


@dataclass(frozen=True)
class ClothingConfig:
    """Who is dressed alike."""

    difference: float = parameter(
        0.2,
        'Squared Hellinger distance of templates from which they are of different kits',
        minimum=0.001,
        maximum=1.0,
    )
    least_age: float = parameter(
        1.0, 'Age from which a track has a kit [s]', minimum=0.0, maximum=1000.0
    )
    time: float = parameter(10.0, 'Time constant of a kit [s]', minimum=0.01, maximum=10000.0)


@dataclass(frozen=True)
class ReidConfig:
    """Who is who after an encounter."""

    contact_distance: float = parameter(
        1.5, 'Who is nearer to another may leave as that one [m]', minimum=0.0, maximum=100.0
    )
    look_time: float = parameter(
        0.5,
        'Time for which one must be seen alone, by all cameras together, to be recognised [s]',
        minimum=0.01,
        maximum=1000.0,
    )
    longest_look_time: float = parameter(
        5.0,
        'Time after which one who looks like several keeps his id [s]',
        minimum=0.01,
        maximum=10000.0,
    )
    trust_time: float = parameter(
        1.0,
        'Time for which one must be seen for his colours to count half [s]',
        minimum=0.0,
        maximum=1000.0,
    )
    strange: float = parameter(
        4.0,
        'What the colours of two people usually differ by, in variances of one',
        minimum=0.0,
        maximum=1000.0,
    )
    new: float = parameter(
        2.5,
        'What they differ by at most if a new track is one who was lost [same]',
        minimum=0.0,
        maximum=1000.0,
    )
    keep: float = parameter(
        0.15,
        'How much more probable it must be before an id changes [log]',
        minimum=0.0,
        maximum=1000.0,
    )
    margin: float = parameter(
        0.1,
        'How much less probable all others must be before it is settled [log]',
        minimum=0.0,
        maximum=1000.0,
    )
    lost_time: float = parameter(
        20.0, 'For how long one who was lost may be found again [s]', minimum=0.0, maximum=10000.0
    )
    speed: float = parameter(3.0, 'How fast he may have gone on [m/s]', minimum=0.0, maximum=100.0)
    arrival_density: float = parameter(
        0.001,
        'How likely somebody new comes into view where one who was lost may [1/m^2]',
        minimum=1e-9,
        maximum=100.0,
    )
    memory_time: float = parameter(
        20.0,
        'Time in view, of all cameras together, that is remembered of his colours [s]',
        minimum=0.01,
        maximum=100000.0,
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
    kits: ClothingConfig = ClothingConfig()
    recognition: ReidConfig = ReidConfig()
