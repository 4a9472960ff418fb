"""Parameters of the tracker that explains the cameras' masks together."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter, tag
from mctrack_ros.fusion.joint_tracker.config import JointConfig


@dataclass(frozen=True)
class PeopleConfig:
    """How people are looked for."""

    cell: float = parameter(
        0.15, 'Distance of the places where people are looked for [m]', minimum=0.02, maximum=10.0
    )
    person_height: float = parameter(
        1.8, 'Height of a person in the masks [m]', minimum=0.1, maximum=10.0
    )
    person_width: float = parameter(
        0.5, 'Width of a person in the masks [m]', minimum=0.05, maximum=10.0
    )
    person_cost: float = parameter(
        0.05,
        'Share of the masks that a person must explain, over all cameras: more finds fewer',
        minimum=0.001,
        maximum=1.0,
    )


@dataclass(frozen=True)
class OccupancyConfig(JointConfig):
    """Parameters of `OccupancyTracker`: those of the joint tracker, and how people are found."""

    tracker: str = tag('occupancy')
    people: PeopleConfig = PeopleConfig()


@dataclass(frozen=True)
class VehicleConfig(JointConfig):
    """Parameters of `VehicleTracker`: those of the joint tracker."""

    tracker: str = tag('vehicles')
