"""Identities swapped in a scrum are found later and corrected; those who look alike are left."""

from __future__ import annotations

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
from mctrack_experiments.scenarios.staged.stage import Stage, hidden_in
from mctrack_experiments.scenarios.staged.walks import walk

Floats = NDArray[np.float64]

MEET_S, SPEED_M_S = 6.0, 1.3
BEFORE_S, PARTED_S, AFTER_S = (3.0, 5.0), (0.7, 1.1), 9.0
"""When ids are compared: before anybody is near, as soon as they are apart, long after; the last
two counted from when they part."""

GROUPS = ('pair_different', 'scrum', 'pair_alike')


def swapped_kits(seed: int, group: str) -> dict[str, bool]:
    """
    Play one scene: people come together, stand as one in every image, and go, pass or turn back.

    Parameters
    ----------
    seed : int
        Of all that is left to chance.
    group : str
        Of `GROUPS`: two of different kits, two of each kit, two who look the same.

    Returns
    -------
    dict of str to bool
        ``swapped``: some had another's id as they came apart; ``right``: everybody has the id of
        one of his kit at last; ``kept``: everybody has his own; ``corrected``: after the meeting
        a correction was published.

    """
    rng = np.random.default_rng([seed, 1])
    stay = rng.uniform(1.5, 3.0)
    seconds = MEET_S + stay + AFTER_S
    paths = turned(_paths(4 if group == 'scrum' else 2, stay, seconds, rng), rng.uniform(0, 6.28))
    kit = (EVERYBODY_ALIKE if group == 'pair_alike' else TWO_TEAMS)[: paths.shape[1]]
    personal = 0.0 if group == 'pair_alike' else PERSONAL
    stage = Stage(paths, kit, AROUND, hidden_in(paths, (), len(AROUND)), personal)
    return _judged(play(stage, seed), kit, MEET_S + stay)


def _judged(played: Played, kit: NDArray[np.int64], parts_s: float) -> dict[str, bool]:
    before = played.ids(*BEFORE_S)
    early = played.ids(parts_s + PARTED_S[0], parts_s + PARTED_S[1])
    after = played.ids(parts_s + AFTER_S - 1.0, parts_s + AFTER_S)
    worn = dict(zip(before, kit.tolist()))
    changed = {frozenset(pair) for pair in played.corrections(parts_s)}
    return {
        'swapped': any(name in before and name != own for name, own in zip(early, before)),
        'right': [worn.get(name) for name in after] == kit.tolist(),
        'kept': keeps(before, after),
        'corrected': bool(changed),
    }


def _paths(people: int, stay: float, seconds: float, rng: np.random.Generator) -> Floats:
    """Return the (ticks, people, 2) paths: in from all sides, and out by one side each."""
    come = np.arange(people) * 2 * np.pi / people + rng.uniform(-0.3, 0.3, people)
    go = rng.permutation(come)
    away = SPEED_M_S * MEET_S
    paths = []
    for into, out in zip(come.tolist(), go.tolist()):
        near = 0.2 * np.array([np.cos(into), np.sin(into)])
        far, gone = (away * np.array([np.cos(a), np.sin(a)]) for a in (into, out))
        left = MEET_S + stay + away / SPEED_M_S
        stops = [(0.0, *far), (MEET_S, *near), (MEET_S + stay, *near), (left, *gone)]
        paths.append(walk(stops, seconds, rng))
    return np.stack(paths, axis=1)
