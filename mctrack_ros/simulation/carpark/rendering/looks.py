"""Shades of grey: clothes that are close to the asphalt's, cars, light and shadow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.carpark.activity.cast import Actor
from mctrack_ros.simulation.carpark.rendering.vehicles import Part
from mctrack_ros.simulation.rendering.bodies import METAL, Cloth

ASPHALT, PAVEMENT, GRASS, HEDGE, PAINT = 106.0, 111.0, 100.0, 84.0, 122.0
"""Grey levels of the ground."""

SHADOW = 0.90
"""What is left of the light in a shadow, under a veiled sun."""

_CONTRASTS = ((0.0, 10.0), (17.0, 24.0), (24.0, 46.0))
_SHARES = (0.04, 0.26, 0.70)
"""How far clothes are from the asphalt's grey, and how many of them."""

_BODIES = ((68.0, 84.0), (124.0, 150.0), (92.0, 120.0))
_GLASS, _WHEEL, _SKIRT = 66.0, 58.0, 60.0


def shades(actors: list[Actor], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the (n, parts) grey levels of everybody's `Cloth` or `Part`."""
    palette = np.zeros((len(actors), len(Part)))
    for row, actor in zip(palette, actors):
        if actor.class_id == ClassCode.VEHICLE:
            _paint(row, rng)
        else:
            _dress(row, rng)
    return np.clip(np.round(palette), 0, 255).astype(np.uint8)


def _dress(row: NDArray[np.float64], rng: np.random.Generator) -> None:
    """Give somebody jacket, trousers, shoes, skin and hair."""
    row[Cloth.SHIRT] = ASPHALT + _contrast(rng)
    row[Cloth.SLEEVE] = row[Cloth.SHIRT] - 2
    row[[Cloth.SHORTS, Cloth.SOCK]] = ASPHALT + _contrast(rng)
    row[Cloth.SHOE] = ASPHALT - rng.uniform(16, 40)
    row[Cloth.SKIN] = ASPHALT + rng.uniform(16, 40)
    row[Cloth.HAIR] = ASPHALT - rng.uniform(18, 46)
    row[METAL] = _WHEEL


def _paint(row: NDArray[np.float64], rng: np.random.Generator) -> None:
    """Give a car its colour; the sun lights some sides."""
    body = rng.uniform(*_BODIES[rng.integers(len(_BODIES))])
    row[Part.LIT_SIDE], row[Part.SHADED_SIDE] = body, 0.86 * body
    row[Part.TOP], row[Part.ROOF] = 1.08 * body, 1.10 * body
    row[Part.GLASS] = _GLASS + rng.uniform(-5, 9)
    row[[Part.WHEEL, Part.SKIRT]] = _WHEEL, _SKIRT
    row[Part.LAMP] = body + rng.uniform(-10, 25)


def _contrast(rng: np.random.Generator) -> float:
    """Return how much brighter or darker than the asphalt a piece of cloth is."""
    low, high = _CONTRASTS[rng.choice(len(_CONTRASTS), p=_SHARES)]
    return float(rng.uniform(low, high) * (1 if rng.random() < 0.4 else -1))
