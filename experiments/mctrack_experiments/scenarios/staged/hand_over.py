"""From camera to camera along a way: one id, across an overlap and across a strip nobody sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.scenarios.rooms import (
    EVERYBODY_ALIKE,
    LENGTH_M,
    PERSONAL,
    TWO_TEAMS,
    corridor,
)
from mctrack_experiments.scenarios.staged.playing import keeps, play
from mctrack_experiments.scenarios.staged.stage import Stage, hidden_in
from mctrack_experiments.scenarios.staged.walks import walk

Floats = NDArray[np.float64]

OVERLAP_M, BLIND_M = (2.0, 6.0), (3.0, 6.0)
SPEED_M_S = (1.1, 1.7)
LEAD_M = 10.0
"""How far people go before the middle and after it, m."""
PEOPLE = ('one', 'two_different', 'two_same', 'opposite_different', 'opposite_same')
GAPS = ('overlap', 'blind')
STRANGERS = ('different', 'same')
"""Kit of one who comes out where another went."""


def hand_over(seed: int, gap: str, people: str) -> dict[str, bool]:
    """
    Play one scene.

    Parameters
    ----------
    seed : int
        Of all that is left to chance.
    gap : str
        Of `GAPS`: what lies between the cameras' fields.
    people : str
        Of `PEOPLE`: one, two side by side, or two who pass each other in the middle; of kits that
        differ or are the same.

    Returns
    -------
    dict of str to bool
        ``kept``: all have the ids afterwards that they had before.

    """
    rng = np.random.default_rng([seed, 1])
    paths, width, seconds = _paths(gap, people, rng)
    kit = (EVERYBODY_ALIKE if people.endswith('same') else TWO_TEAMS)[: paths.shape[1]]
    stage = Stage(paths, kit, corridor(width), hidden_in(paths, (), 2), PERSONAL)
    played = play(stage, seed)
    before, after = played.ids(2.0, 3.5), played.ids(seconds - 1.5, seconds)
    return {'kept': keeps(before, after)}


def stranger(seed: int, kits: str) -> dict[str, bool]:
    """
    Play a scene in which one goes where nobody sees him and stays, and another comes out.

    Parameters
    ----------
    seed : int
        Of all that is left to chance.
    kits : str
        Of `STRANGERS`.

    Returns
    -------
    dict of str to bool
        ``told_apart``: the other has an id of his own.

    """
    rng = np.random.default_rng([seed, 1])
    width, speed = rng.uniform(*BLIND_M), rng.uniform(*SPEED_M_S)
    arrives = LEAD_M / speed
    appears = arrives + rng.uniform(width / speed, 8.0)
    seconds = appears + 6.0
    y = rng.uniform(-1.0, 1.0, 2)
    stays = [(0.0, -LEAD_M - width / 2, y[0]), (arrives + width / 2 / speed, 0.0, y[0])]
    comes = [(appears - width / 2 / speed, 0.0, y[1]), (seconds, 6 * speed + width / 2, y[1])]
    paths = np.stack([walk(stops, seconds, rng) for stops in (stays, comes)], axis=1)
    kit = (EVERYBODY_ALIKE if kits == 'same' else TWO_TEAMS)[:2]
    stage = Stage(paths, kit, corridor(-width), hidden_in(paths, (), 2), PERSONAL)
    played = play(stage, seed)
    first, other = played.ids(2.0, 3.5)[0], played.ids(seconds - 1.5, seconds)[1]
    return {'told_apart': first != other and 0 not in (first, other)}


def _paths(gap: str, people: str, rng: np.random.Generator) -> tuple[Floats, float, float]:
    """Return (ticks, people, 2) paths, the overlap of the fields, m, and how long it takes, s."""
    width = rng.uniform(*OVERLAP_M) if gap == 'overlap' else -rng.uniform(*BLIND_M)
    reach, speed = min(LEAD_M + abs(width) / 2, LENGTH_M), rng.uniform(*SPEED_M_S)
    seconds = 2 * reach / speed
    side, apart = rng.choice([-1.0, 1.0]), rng.uniform(1.0, 2.0)
    lanes = [0.0] if people == 'one' else [-apart / 2, apart / 2]
    paths = []
    for index, lane in enumerate(lanes):
        way = -side if people.startswith('opposite') and index else side
        late = rng.uniform(-0.4, 0.4)
        stops = [(late, -way * reach, lane), (seconds + late, way * reach, lane)]
        paths.append(walk(stops, seconds, rng))
    return np.stack(paths, axis=1), float(width), float(seconds)
