"""How often something happened, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

NORMAL_95 = 1.959964


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """
    Return the 95 % interval of a rate (Wilson 1927).

    Parameters
    ----------
    successes, trials : int
        What was counted; without trials the interval is all there is, 0 to 1.

    """
    if trials == 0:
        return 0.0, 1.0
    rate, square = successes / trials, NORMAL_95**2 / trials
    middle = (rate + square / 2) / (1 + square)
    half = np.sqrt(square * (rate * (1 - rate) + square / 4)) / (1 + square)
    return max(float(middle - half), 0.0), min(float(middle + half), 1.0)


def rate_figures(name: str, outcomes: Sequence[bool]) -> dict[str, float]:
    """Return the share of outcomes that are true, its interval, and how many there are."""
    low, high = wilson(sum(outcomes), len(outcomes))
    return {
        f'{name}.rate': float(np.mean(outcomes)) if outcomes else float('nan'),
        f'{name}.low': low,
        f'{name}.high': high,
        f'{name}.cases': len(outcomes),
    }
