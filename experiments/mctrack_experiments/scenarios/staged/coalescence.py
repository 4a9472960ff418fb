"""Two who walk side by side, or cross at an acute angle: two tracks, which keep their ids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.scenarios.rooms import (
    AROUND,
    EVERYBODY_ALIKE,
    PERSONAL,
    TWO_TEAMS,
    turned,
)
from mctrack_experiments.scenarios.staged.playing import Played, keeps, play
from mctrack_experiments.scenarios.staged.stage import TICK_S, Stage, hidden_in
from mctrack_experiments.scenarios.staged.walks import walk
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.association.config import ASSOCIATION

Floats = NDArray[np.float64]

ASSOCIATORS = ('weighed_gnn', 'gnn', 'jpda')
SECONDS = 13.0
BEFORE_S, TOGETHER_S, AFTER_S = (1.5, 3.0), (4.0, 10.0), (12.0, 13.0)
LONGEST_LOSS_S = 1.0
KITS = {'different': TWO_TEAMS, 'same': EVERYBODY_ALIKE, 'places': EVERYBODY_ALIKE}
"""`places`: cameras tell places alone, and take two who are one detection for one."""


def side_by_side(rng: np.random.Generator) -> Floats:
    """Return the (ticks, 2, 2) paths of two who walk 0.4 to 0.7 m apart for four seconds."""
    gap, speed = rng.uniform(0.2, 0.35), rng.uniform(1.0, 1.4)
    times, aside = (0.0, 3.0, 4.5, 8.5, 10.0, SECONDS), (2.0, 2.0, gap, gap, 2.0, 2.0)
    along = [speed * (time - SECONDS / 2) for time in times]
    return np.stack(
        [
            walk(list(zip(times, along, [side * y for y in aside])), SECONDS, rng)
            for side in (-1, 1)
        ],
        axis=1,
    )


def acute(rng: np.random.Generator) -> Floats:
    """Return the (ticks, 2, 2) paths of two whose ways cross at 10 to 25 degrees."""
    half, speed = np.radians(rng.uniform(5.0, 12.5)), rng.uniform(1.2, 1.5)
    late = rng.uniform(-0.15, 0.15)
    paths = []
    for side in (-1, 1):
        velocity = speed * np.array([np.cos(half), side * np.sin(half)])
        ends = [(time, *(velocity * (time - 6.5 + side * late))) for time in (0.0, SECONDS)]
        paths.append(walk(ends, SECONDS, rng))
    return np.stack(paths, axis=1)


WAYS = {'side_by_side': side_by_side, 'acute': acute}


def coalescence(seed: int, way: str, kits: str, method: str) -> dict[str, bool]:
    """
    Play one scene.

    Parameters
    ----------
    seed : int
        Of all that is left to chance.
    way : str
        Of `WAYS`.
    kits : str
        Of `KITS`.
    method : str
        The associator.

    Returns
    -------
    dict of str to bool
        ``kept``: both have the ids afterwards that they had before; ``two``: never is one of them
        without a track for a second.

    """
    rng = np.random.default_rng([seed, 1])
    paths = turned(WAYS[way](rng), rng.uniform(0, 2 * np.pi))
    stage = Stage(paths, KITS[kits][:2], AROUND, hidden_in(paths, (), 3), PERSONAL)
    config = JointConfig()
    config = replace(config, association=ASSOCIATION.made(method))
    played = play(stage, seed, config, places_only=kits == 'places')
    kept = keeps(played.ids(*BEFORE_S), played.ids(*AFTER_S))
    return {'kept': kept, 'two': _stay_two(played)}


def _stay_two(played: Played) -> bool:
    """Tell whether both have a track of their own but for less than a second on end."""
    missing = 0
    for tick in range(round(TOGETHER_S[0] / TICK_S), round(TOGETHER_S[1] / TICK_S)):
        missing = 0 if len(played.matched(tick)) == 2 else missing + 1
        if missing * TICK_S >= LONGEST_LOSS_S:
            return False
    return True
