"""The event-tracking paper's Figure 20: paths of two players, true and estimated, with events."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from mctrack_experiments.papers.event_tracking.happenings import Happening
from mctrack_experiments.papers.event_tracking.paths import MatchedPath, matched_paths
from mctrack_experiments.papers.event_tracking.tracked_match import TrackedMatch
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import EventCode
from mctrack_ros.report.ground_plan import pitch_lines
from mctrack_ros.simulation import Scenario, World

SEED = 26
"""Held out: the tracker is tuned on seeds 1 to 6, 61 and 62."""

DURATION_S = 60.0
GATE_M = 1.0
LETTERS = {EventCode.NEW: 'N', EventCode.MERGE: 'G', EventCode.SPLIT: 'S'}
"""As the paper's figure marks them."""

ABOVE_M = {'N': 0.0, 'G': 1.2, 'S': -1.2}
"""Where the letters stand, so that they can be told apart."""

_ARROW = {'arrowstyle': '-', 'color': '#888888', 'linewidth': 0.5}
_COLOURS = ('#2166ac', '#b2182b')


Mark = tuple[str, float, float]
"""Letter of an event, and where its player was, m."""


@dataclass(frozen=True, eq=False, slots=True)
class Player:
    """One player: true id, path, and a mark for every event that one camera told of him."""

    person: int
    path: MatchedPath
    marks: tuple[Mark, ...]

    def figures(self) -> dict[str, float]:
        """Return errors and correlation over the two axes, and the count of each mark."""
        name = f'player{self.person}'
        figures = {}
        for axis, rmse_m, correlation in zip('xy', self.path.rmse_m(), self.path.correlation()):
            figures[f'{name}.rmse_{axis}_m'] = float(rmse_m)
            figures[f'{name}.correlation_{axis}'] = float(correlation)
        counts = Counter(letter for letter, _, _ in self.marks)
        return figures | {f'{name}.{letter}': counts[letter] for letter in LETTERS.values()}


def reproduce_fig20(
    image: Path | None = None, seed: int = SEED, duration_s: float = DURATION_S
) -> Figures:
    """
    Track a match and follow the two players who run farthest.

    Parameters
    ----------
    image : Path, optional
        Where to draw their paths, as PNG.
    seed : int
        Of the match.
    duration_s : float
        Its length, s.

    """
    world = World.simulated(Scenario(seed=seed, duration_s=duration_s))
    with tempfile.TemporaryDirectory() as scratch:
        match = TrackedMatch.made(world, Path(scratch))
        told = {camera: match.happenings(camera)[1] for camera in match.cameras}
        paths = matched_paths(*match.trajectories(), GATE_M)
    run_m = np.linalg.norm(world.motion.velocity, axis=2).sum(axis=0) * world.scenario.period_s
    farthest = [person for person in (np.argsort(-run_m) + 1).tolist() if person in paths]
    players = [_player(person, paths[person], told, world) for person in farthest[:2]]
    if image is not None:
        draw_players(players, image)
    return Figures(
        name='fig20',
        command='mctrack reproduce fig20',
        protocol={
            'scene': f'pitch5, {duration_s:g} s, 5 cameras, seed {seed}',
            'players': 'the two who run farthest',
            'marks': 'N new, G merge, S split, by the camera that told most of each',
            'gate_m': GATE_M,
        },
        figures={name: value for player in players for name, value in player.figures().items()},
    )


def draw_players(players: Sequence[Player], image: Path) -> None:
    """Draw true paths broad and pale, estimated ones thin, and a letter for every event."""
    figure = Figure(figsize=(12, 9), layout='constrained')
    for axes, player, colour in zip(figure.subplots(2, 1), players, _COLOURS):
        _draw_player(axes, player, colour)
    figure.savefig(image, dpi=110)


def _draw_player(axes: Axes, player: Player, colour: str) -> None:
    path = player.path
    axes.add_collection(LineCollection(pitch_lines(), colors='#999999', linewidths=0.6))
    gaps = np.flatnonzero(np.diff(path.frame) > 1) + 1
    pieces = zip(np.split(path.true, gaps), np.split(path.found, gaps))
    for number, (true, found) in enumerate(pieces):
        axes.plot(*true.T, color='#c8c8c8', linewidth=5, label='' if number else 'true')
        axes.plot(*found.T, color=colour, linewidth=1.2, label='' if number else 'estimated')
    for letter, x, y in player.marks:
        place = (x, y + ABOVE_M[letter])
        axes.annotate(
            letter, (x, y), place, fontsize=8, ha='center', va='center', arrowprops=_ARROW
        )
    low, high = path.true.min(axis=0) - 2, path.true.max(axis=0) + 2
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect='equal')
    axes.set(xlabel='x [m]', ylabel='y [m]', title=f'player {player.person}')
    axes.legend(fontsize=8)


def _player(
    person: int, path: MatchedPath, told: Mapping[str, Sequence[Happening]], world: World
) -> Player:
    """Return a player with what the camera told of him that told most."""
    by_camera: list[list[Mark]] = [
        [_mark(one, person, world) for one in each if _is_marked(one, person)]
        for each in told.values()
    ]
    most = max(by_camera, key=len)
    return Player(person, path, tuple(most))


def _is_marked(happening: Happening, person: int) -> bool:
    return person in happening.targets and happening.event in LETTERS


def _mark(happening: Happening, person: int, world: World) -> Mark:
    seconds = (happening.stamp_ns - world.scenario.start_ns) * 1e-9
    step = min(int(seconds * world.scenario.rate_hz), world.scenario.steps - 1)
    x, y = world.motion.position[step, person - 1].tolist()
    return LETTERS[EventCode(happening.event)], x, y
