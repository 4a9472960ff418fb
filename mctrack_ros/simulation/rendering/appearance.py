"""What people wear: three kits, skin and hair, the same person always the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.pitch.intent import PLAYERS, TEAM
from mctrack_ros.simulation.rendering.bodies import Cloth
from mctrack_ros.simulation.scenario import Scenario

_KITS = {
    0: {Cloth.SHIRT: (38, 38, 196), Cloth.SHORTS: (225, 225, 225), Cloth.SOCK: (38, 38, 190)},
    1: {Cloth.SHIRT: (196, 110, 36), Cloth.SHORTS: (120, 58, 26), Cloth.SOCK: (225, 225, 225)},
    2: {Cloth.SHIRT: (40, 205, 228), Cloth.SHORTS: (30, 30, 30), Cloth.SOCK: (30, 30, 30)},
}
"""Blue, green, red of the kits of the two teams and the referees."""

_SHOE = (30, 30, 34)
_SKIN = np.array([(150, 180, 225), (120, 150, 200), (70, 100, 150), (45, 65, 100)])
_HAIR = np.array([(20, 22, 28), (35, 55, 85), (90, 140, 180)])
_BRIGHTNESS = 0.04
_HEIGHT_M = (1.70, 1.92)


@dataclass(frozen=True, eq=False, slots=True)
class Appearance:
    """
    Looks of all people.

    Attributes
    ----------
    palette : (n, 8, 3) uint8 array
        Blue, green, red of each `Cloth`.
    height : (n,) array
        Height, m.
    kit : (n,) uint8 array
        1 and 2: the teams, 3: the referees.

    """

    palette: NDArray[np.uint8]
    height: NDArray[np.float64]
    kit: NDArray[np.uint8]


def dressed(scenario: Scenario) -> Appearance:
    """Dress everybody; within a kit only brightness differs, and little."""
    rng = np.random.default_rng([scenario.seed, 3])
    palette = np.zeros((PLAYERS, len(Cloth), 3))
    for person, team in enumerate(TEAM.tolist()):
        for cloth, colour in _KITS[team].items():
            palette[person, cloth] = colour
        palette[person, Cloth.SLEEVE] = 0.88 * palette[person, Cloth.SHIRT]
        palette[person] *= 1 + rng.uniform(-_BRIGHTNESS, _BRIGHTNESS)
        palette[person, Cloth.SHOE] = _SHOE
        palette[person, Cloth.SKIN] = _SKIN[rng.integers(len(_SKIN))]
        palette[person, Cloth.HAIR] = _HAIR[rng.integers(len(_HAIR))]
    height = rng.uniform(*_HEIGHT_M, PLAYERS)
    colours = np.clip(np.round(palette), 0, 255).astype(np.uint8)
    return Appearance(colours, height, (TEAM + 1).astype(np.uint8))
