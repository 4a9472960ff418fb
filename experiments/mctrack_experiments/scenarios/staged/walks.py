"""Ways that people go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.scenarios.staged.stage import TICK_S

Floats = NDArray[np.float64]

TURN_S = 0.4
"""Time in which one changes his velocity, s."""
SWAY_M, SWAY_S = 0.05, 0.5
"""How far, and how quickly, people sway about their way: m and s."""


def walk(
    stops: Sequence[tuple[float, float, float]], seconds: float, rng: np.random.Generator
) -> Floats:
    """
    Return the (ticks, 2) places of one who goes from stop to stop (s, m, m), and sways.

    Corners are rounded: he is where a walker without inertia is in the mean over `TURN_S`.
    """
    times = np.arange(round(seconds / TICK_S)) * TICK_S
    when, *where = np.array(stops).T
    within_turn = np.linspace(-TURN_S / 2, TURN_S / 2, 11)[:, None]
    place = [np.interp(times + within_turn, when, axis).mean(axis=0) for axis in where]
    steps = rng.normal(0.0, 1.0, (len(times), 2))
    sway, decay = np.zeros((len(times), 2)), np.exp(-TICK_S / SWAY_S)
    slow = np.zeros(2)
    for tick in range(1, len(times)):  # twice smoothed: nobody jerks
        slow = decay * slow + np.sqrt(1 - decay**2) * steps[tick]
        sway[tick] = decay * sway[tick - 1] + (1 - decay) * SWAY_M * np.sqrt(2) * slow
    return np.column_stack(place) + sway


def straight(
    start: tuple[float, float],
    end: tuple[float, float],
    times: tuple[float, float],
    rng: np.random.Generator,
) -> Floats:
    """Return the places of one who goes straight from time 0 to the second, setting off first."""
    stops = [(times[0], *start), (times[1], *end)]
    return walk(stops, times[1], rng)
