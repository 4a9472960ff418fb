"""The grey car park: four cameras around it, six people among three cars."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mctrack_ros.simulation.cameras import Camera, looking_at
from mctrack_ros.simulation.carpark import layout
from mctrack_ros.simulation.carpark.activity.activities import Activities
from mctrack_ros.simulation.carpark.activity.cast import Actor, Cast
from mctrack_ros.simulation.carpark.activity.routes import Routes
from mctrack_ros.simulation.carpark.world import CarParkWorld, staged
from mctrack_ros.simulation.scenario import Scenario

_MASTS = ((-3.0, -6.0), (43.0, -6.0), (43.0, 37.0), (-3.0, 37.0))
_MAST_M, _FOCAL_PX = 7.0, 520.0
_FIRST_S, _TRIES, _CASTS = (2.0, 12.0), 500, 20
"""When somebody comes first, s; how often he is sent at another time, and all anew."""
_NEAR_M = 11.0


@dataclass(frozen=True, slots=True)
class GreyCarParkScenario(Scenario):
    """
    A recording of the grey car park.

    Four monochrome cameras of 640 x 480 px and low contrast see it from its corners. A car parks,
    one leaves its bay, one drives through; both drivers and four others walk among them. The light
    changes slowly by the amplitude ``lighting_drift``.
    """

    MOST_CAMERAS: ClassVar[int] = len(_MASTS)

    duration_s: float = 60.0
    rate_hz: float = 12.5
    cameras: int = len(_MASTS)
    width: int = 640
    height: int = 480
    noise: float = 2.6
    shadows: bool = True
    lighting_drift: float = 0.06

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        super(GreyCarParkScenario, self).__post_init__()
        if self.duration_s < 2 * _FIRST_S[1]:
            raise ValueError(
                f'duration_s is {self.duration_s:g}, expected {2 * _FIRST_S[1]:g} or more'
            )


def grey_carpark_cameras(scenario: Scenario) -> tuple[Camera, ...]:
    """Return the cameras, on masts of 7 m at the corners."""
    middle = (layout.LENGTH_M / 2, layout.WIDTH_M / 2, 0.0)
    return tuple(
        looking_at(f'cam{number}', (x, y, _MAST_M), middle, _FOCAL_PX, scenario)
        for number, (x, y) in enumerate(_MASTS[: scenario.cameras], 1)
    )


def grey_carpark_world(scenario: GreyCarParkScenario) -> CarParkWorld:
    """Return the world of a scenario."""
    return staged(scenario, _cast(scenario), grey_carpark_cameras(scenario))


def _cast(scenario: GreyCarParkScenario) -> list[Actor]:
    """Return three cars and six people, nobody of whom is run over."""
    for attempt in range(_CASTS):
        actors = _fitting_cast(scenario, np.random.default_rng([scenario.seed, 21, attempt]))
        if actors is not None:
            return actors
    raise ValueError(f'seed {scenario.seed}: nobody fits between the cars; take another')


def _fitting_cast(scenario: GreyCarParkScenario, rng: np.random.Generator) -> list[Actor] | None:
    """Return three cars and six people; None: somebody would be run over whenever he came."""
    cast = Cast(scenario.period_s)
    (front,) = layout.carpark_cameras(scenario)  # people come from beyond what it would show
    act = Activities(cast, Routes(front, rng), scenario.steps, scenario.period_s, rng)
    middle = layout.LENGTH_M / 2
    near = [bay for bay in layout.bays() if abs(bay.x - middle) < _NEAR_M]
    leaves, free = (near[index] for index in rng.choice(len(near), 2, replace=False))
    parked = act.parked(leaves)
    plans: list[Callable[[int], list[Actor]]] = [
        lambda first: act.depart(first, parked, leaves),
        lambda first: act.arrive(first, free),
        act.drive_through,
        act.loiter,
        act.loiter,
        act.meet,
    ]
    for plan in plans:
        actors = _fitting(plan, cast, scenario, rng)
        if actors is None:
            return None
        cast.actors += actors
    return cast.actors


def _fitting(
    plan: Callable[[int], list[Actor]],
    cast: Cast,
    scenario: GreyCarParkScenario,
    rng: np.random.Generator,
) -> list[Actor] | None:
    """Return actors who come near to no car that moves and stay to the end; None: not found."""
    for _ in range(_TRIES):
        actors = plan(round(rng.uniform(*_FIRST_S) * scenario.rate_hz))
        if min(actor.first for actor in actors) < 0:
            continue
        actors = [
            Actor(
                actor.class_id,
                actor.party,
                actor.first,
                actor.course.until(scenario.steps - actor.first),
                actor.size,
            )
            for actor in actors
            if actor.first < scenario.steps
        ]
        if not any(cast.collides(actor) for actor in actors):
            return actors
    return None
