"""A scripted match: five targets, each hidden four times in four ways, before two cameras."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation import (
    PITCH5,
    PTZ,
    Camera,
    PtzScenario,
    Renderer,
    Scenario,
    Sight,
    Walk,
    World,
    staged,
)
from mctrack_ros.simulation.pitch import field
from mctrack_ros.simulation.world import pitch_cameras

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

TARGETS = 5
LEAD_S, SLOT_S = 2.0, 7.0
HIDDEN_BELOW = 0.5
"""A target is hidden in a view while less than this share of the person is visible."""
SWEEP = 0.25
"""Of PTZ cameras, so that all targets stay in both views."""
_JITTER_S = 0.6
_MARGIN_M, _APART_M, _TRIES = 5.0, 5.5, 50
_STROLL_M, _STROLL_S = 1.6, 9.0
_FRONT_M, _BESIDE_M = 0.6, 0.15
_AWAY_M = 4.0
_PASS_S, _PASS_M = 1.4, 1.9
_STAYS_S = {'opponent': 0.4, 'team_mate': 0.4, 'one_view': 0.8, 'both_views': 0.25}
_STOPS_S = 0.2


class Kind(StrEnum):
    """How a target is hidden."""

    OPPONENT = 'opponent'
    TEAM_MATE = 'team_mate'
    ONE_VIEW = 'one_view'
    BOTH_VIEWS = 'both_views'


@dataclass(frozen=True, slots=True)
class Occlusion:
    """
    One scripted occlusion.

    Attributes
    ----------
    kind : Kind
        Opponent or team-mate crosses in front in one view; two opponents stay in front in one
        view; one opponent stays in front in each view for a short time.
    target : int
        Index of the target, from 0.
    centre_s : float
        Its middle, s.
    cameras : tuple of int
        Indices of the cameras in which the target is hidden.

    """

    kind: Kind
    target: int
    centre_s: float
    cameras: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class OcclusionScene:
    """
    A match with occlusions.

    Attributes
    ----------
    world : World
        What goes on.
    persons : tuple of int
        Index of the person that each target is.
    occlusions : tuple of Occlusion
        By time.

    """

    world: World
    persons: tuple[int, ...]
    occlusions: tuple[Occlusion, ...]

    @property
    def truth(self) -> Floats:
        """Return where the targets are, (steps, targets, 2) m."""
        return self.world.motion.position[:, self.persons]

    @cached_property
    def visible(self) -> Floats:
        """Return the share of each target that is visible, (steps, cameras, targets)."""
        return visible_shares(self.world, self.persons)

    @cached_property
    def renderers(self) -> list[Renderer]:
        """What draws the images of each camera."""
        scene = PTZ if isinstance(self.world.scenario, PtzScenario) else PITCH5
        return [scene.renderer(self.world, index) for index in range(len(self.world.cameras))]

    def hidden(self, occlusion: Occlusion) -> tuple[int, int]:
        """Return the first step that an occlusion hides its target, and that after the last."""
        rate = self.world.scenario.rate_hz
        middle, reach = round(occlusion.centre_s * rate), round(SLOT_S / 2 * rate)
        steps = np.arange(middle - reach, min(middle + reach, len(self.visible)))
        shares = self.visible[steps][:, occlusion.cameras, occlusion.target]
        hidden = steps[(shares < HIDDEN_BELOW).any(axis=1)]
        if not len(hidden):
            return middle, middle
        runs = np.split(hidden, np.flatnonzero(np.diff(hidden) > 1) + 1)
        run = min(runs, key=lambda each: np.abs(each - middle).min())
        return int(run[0]), int(run[-1]) + 1

    def frames(self) -> Iterator[tuple[Mapping[str, Camera], Mapping[str, Image]]]:
        """Yield true cameras and images by name, step by step."""
        for step in range(self.world.scenario.steps):
            cameras = {camera.name: camera for camera in self.world.views(step)}
            shown = [renderer.frame(step)[0] for renderer in self.renderers]
            yield cameras, dict(zip(cameras, shown))


def visible_shares(world: World, persons: Sequence[int] | NDArray[np.int64]) -> Floats:
    """Return the share of each of some persons that is visible, (steps, cameras, persons)."""
    shares = np.zeros((world.scenario.steps, len(world.cameras), len(persons)))
    for camera in range(len(world.cameras)):
        sight = Sight(world, camera)
        for step in range(len(shares)):
            view = sight.view(step)
            rows, columns = np.nonzero(view.person[:, None] == np.asarray(persons))
            shares[step, camera, columns] = view.visible[rows]
    return shares


def scripted(seed: int, moving: bool = False, rate_hz: float = 25.0) -> OcclusionScene:
    """
    Return the scripted match of a seed: 20 occlusions in 30 s.

    Parameters
    ----------
    seed : int
        Of places, paths, order and times.
    moving : bool
        Whether the cameras pan, tilt and zoom.
    rate_hz : float
        Images a second.

    """
    rng = np.random.default_rng([seed, 9])
    seconds = LEAD_S + SLOT_S * len(Kind)
    scenario: Scenario
    if moving:
        scenario = PtzScenario(seed=seed, duration_s=seconds, rate_hz=rate_hz, sweep=SWEEP)
    else:
        scenario = Scenario(seed=seed, duration_s=seconds, rate_hz=rate_hz, cameras=2)
    stations, eyes = _stations(scenario, rng)
    walks, occlusions, persons = [], [], []
    for target, station in enumerate(stations):
        group = _group(target)
        own = _hidings(target, rng)
        stroll = _stroll(station, seconds, rng)
        offsets = _offsets(own, stroll, eyes, seconds)
        walks += [
            Walk(person, _stops(seconds, stroll + offset))
            for person, offset in zip(group, offsets)
        ]
        occlusions += own
        persons.append(group[0])
    order = sorted(occlusions, key=lambda each: each.centre_s)
    return OcclusionScene(staged(scenario, walks), tuple(persons), tuple(order))


def _group(target: int) -> tuple[int, int, int, int]:
    """Return the persons of a target, a team-mate and two opponents; teams take turns."""
    own, other = (1, 12) if target % 2 == 0 else (12, 1)
    first = 2 * target
    return own + first, own + first + 1, other + first, other + first + 1


def _stations(scenario: Scenario, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return places that all cameras see all the time, (targets, 2) m, and the cameras', too."""
    cameras = pitch_cameras(scenario)
    x, y = np.arange(2, field.LENGTH_M, 1.0), np.arange(2, field.WIDTH_M, 1.0)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    around = grid[None] + _MARGIN_M * np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])[:, None]
    corners = np.concatenate([around, np.zeros((*around.shape[:2], 1))], axis=2)
    steps = range(0, scenario.steps, round(scenario.rate_hz))
    views = {id(view): view for camera in cameras for view in map(camera.at, steps)}
    seen = np.all([view.sees(corners).all(axis=0) for view in views.values()], axis=0)
    chosen: list[Floats] = []
    for _ in range(_TRIES):
        chosen = []
        for place in rng.permutation(grid[seen]):
            if all(np.linalg.norm(place - other) > 2 * _APART_M for other in chosen):
                chosen.append(place)
        if len(chosen) >= TARGETS:
            break
    if len(chosen) < TARGETS:
        raise ValueError(f'{len(chosen)} places are in all views, expected {TARGETS}')
    chosen = chosen[:TARGETS]
    return np.array(chosen), np.array([camera.at(0).position[:2] for camera in cameras])


def _hidings(target: int, rng: np.random.Generator) -> list[Occlusion]:
    """Return one occlusion of each kind in drawn order."""
    occlusions = []
    for slot, kind in enumerate(rng.permutation(list(Kind)).tolist()):
        centre = LEAD_S + SLOT_S * (slot + 0.5) + rng.uniform(-_JITTER_S, _JITTER_S)
        cameras = (0, 1) if kind == Kind.BOTH_VIEWS else (int(rng.integers(2)),)
        occlusions.append(Occlusion(Kind(kind), target, float(centre), cameras))
    return occlusions


def _clock(seconds: float) -> Floats:
    return np.arange(0.0, seconds + _STOPS_S, _STOPS_S)


def _stroll(station: Floats, seconds: float, rng: np.random.Generator) -> Floats:
    """Return where a target walks around a station, (stops, 2) m."""
    phase, pace = rng.uniform(0, 2 * np.pi, 2), rng.uniform(0.8, 1.2, 2)
    turn = 2 * np.pi * _clock(seconds)[:, None] * pace / _STROLL_S + phase
    return np.asarray(station + _STROLL_M * np.sin(turn))


def _offsets(
    occlusions: list[Occlusion], stroll: Floats, eyes: Floats, seconds: float
) -> list[Floats]:
    """Return where target, mate and two opponents are beside the target, (stops, 2) m each."""
    clock = _clock(seconds)
    keys: dict[int, list[tuple[float, Floats]]] = {1: [], 2: [], 3: []}
    for occlusion in occlusions:
        at = int(np.argmin(np.abs(clock - occlusion.centre_s)))
        for role, camera, shift, stays_s in _who(occlusion):
            sight = eyes[camera] - stroll[at]
            sight = sight / np.linalg.norm(sight)
            across = np.array([-sight[1], sight[0]])
            front = _FRONT_M * sight + shift * across
            begin, end = occlusion.centre_s - stays_s / 2, occlusion.centre_s + stays_s / 2
            keys[role] += [
                (begin - _PASS_S, front - _PASS_M * across),
                (begin, front),
                (end, front),
                (end + _PASS_S, front + _PASS_M * across),
            ]
    offsets = [np.zeros((len(clock), 2))]
    for role, angle in ((1, 0.0), (2, 2.1), (3, 4.2)):
        offsets.append(_between(clock, keys[role], angle))
    return offsets


def _who(occlusion: Occlusion) -> list[tuple[int, int, float, float]]:
    """Return role, camera, shift to the side, m, and stay, s, of those who hide a target."""
    camera, stay = occlusion.cameras[0], _STAYS_S[occlusion.kind]
    match occlusion.kind:
        case Kind.OPPONENT:
            return [(2, camera, 0.0, stay)]
        case Kind.TEAM_MATE:
            return [(1, camera, 0.0, stay)]
        case Kind.ONE_VIEW:
            return [(2, camera, -_BESIDE_M, stay), (3, camera, _BESIDE_M, stay)]
        case Kind.BOTH_VIEWS:
            return [(2, 0, 0.0, stay), (3, 1, 0.0, stay)]


def _between(clock: Floats, keys: list[tuple[float, Floats]], angle: float) -> Floats:
    """Return offsets by time, (stops, 2) m: near the target by keys, else some metres away."""
    passes = [keys[first : first + 4] for first in range(0, len(keys), 4)]
    times, radii, angles = [0.0], [_AWAY_M], [angle]
    for each in passes:
        for moment, place in (each[0], each[-1]):
            turned = float(np.arctan2(place[1], place[0]))
            angles.append(angles[-1] + (turned - angles[-1] + np.pi) % (2 * np.pi) - np.pi)
            times.append(moment)
            radii.append(float(np.linalg.norm(place)))
        times.append(times[-1] + 1.2)
        radii.append(_AWAY_M)
        angles.append(angles[-1])
    order = np.argsort(times, kind='stable')
    time = np.array(times)[order]
    radius = np.interp(clock, time, np.array(radii)[order])
    turn = np.interp(clock, time, np.array(angles)[order])
    around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    offsets: Floats = radius[:, None] * around
    for each in passes:
        near = (clock >= each[0][0]) & (clock <= each[-1][0])
        when, places = [moment for moment, _ in each], np.array([place for _, place in each])
        when = [moment + 1e-6 * index for index, moment in enumerate(when)]
        offsets[near] = np.stack(
            [np.interp(clock[near], when, places[:, axis]) for axis in (0, 1)], axis=1
        )
    return offsets


def _stops(seconds: float, path: Floats) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(t), float(x), float(y)) for t, (x, y) in zip(_clock(seconds), path))
