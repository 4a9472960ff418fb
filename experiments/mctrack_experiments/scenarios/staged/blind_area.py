"""Something hides people from every camera for two to four seconds."""

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
from mctrack_experiments.scenarios.staged.playing import keeps, play
from mctrack_experiments.scenarios.staged.stage import Stage
from mctrack_experiments.scenarios.staged.walks import walk

Floats = NDArray[np.float64]

HIDDEN_S = (2.0, 4.0)
LEAD_S = 5.0
PEOPLE = ('one', 'turns', 'two_different', 'two_same')


def blind_area(seed: int, people: str) -> dict[str, bool]:
    """
    Play one scene.

    Parameters
    ----------
    seed : int
        Of all that is left to chance.
    people : str
        Of `PEOPLE`: one who goes straight through, one who turns inside and comes back, two side
        by side.

    Returns
    -------
    dict of str to bool
        ``kept``: all have the ids afterwards that they had before.

    """
    rng = np.random.default_rng([seed, 1])
    speed, hidden_s = rng.uniform(1.1, 1.7), rng.uniform(*HIDDEN_S)
    seconds = 2 * LEAD_S + hidden_s
    half = hidden_s / 2
    apart = rng.uniform(1.0, 2.0)
    lanes = [-apart / 2, apart / 2] if people.startswith('two') else [0.0]
    paths = []
    for lane in lanes:
        begins, middle = (0.0, -speed * (LEAD_S + half), lane), (seconds / 2, 0.0, lane)
        back = -1 if people == 'turns' else 1
        ends = (seconds, back * speed * (LEAD_S + half), lane)
        paths.append(walk([begins, middle, ends], seconds, rng))
    places = np.stack(paths, axis=1)
    hidden = np.abs(places[..., 0]) < speed * half
    kit = (EVERYBODY_ALIKE if people == 'two_same' else TWO_TEAMS)[: len(lanes)]
    stage = Stage(
        turned(places, rng.uniform(0, 2 * np.pi)),
        kit,
        AROUND,
        np.repeat(hidden[:, :, None], len(AROUND), axis=2),
        PERSONAL,
    )
    played = play(stage, seed)
    return {'kept': keeps(played.ids(2.0, 4.0), played.ids(seconds - 1.5, seconds))}
