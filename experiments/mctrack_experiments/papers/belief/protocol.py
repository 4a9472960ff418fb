"""Which scripted occlusions a tracker survives, with confidence intervals over seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.belief.scenes import Kind, OcclusionScene

Floats = NDArray[np.float64]

Kept = Mapping[Kind, NDArray[np.bool_]]
"""By kind of occlusion, which were survived."""

GATE_M, AFTER_S = 1.0, 1.0
_DRAWS, _LEVEL = 2000, 0.95


def kept(scene: OcclusionScene, tracks: Floats) -> Kept:
    """
    Decide for each occlusion whether the right player was kept.

    He was if the target's position is within `GATE_M` of him `AFTER_S` after the occlusion ended.

    Raises
    ------
    ValueError
        If the tracks have another shape than the truth.

    """
    if tracks.shape != scene.truth.shape:
        raise ValueError(f'tracks have shape {tracks.shape}, expected {scene.truth.shape}')
    after = round(AFTER_S * scene.world.scenario.rate_hz)
    missed = np.linalg.norm(tracks - scene.truth, axis=2)
    found: dict[Kind, list[bool]] = {kind: [] for kind in Kind}
    for occlusion in scene.occlusions:
        step = min(scene.hidden(occlusion)[1] - 1 + after, len(missed) - 1)
        found[occlusion.kind].append(bool(missed[step, occlusion.target] <= GATE_M))
    return {kind: np.array(values) for kind, values in found.items()}


def share(runs: Sequence[Kept], kinds: Sequence[Kind]) -> Floats:
    """Return the share of the occlusions of some kinds that was survived, (seeds,)."""
    return np.array([np.concatenate([run[kind] for kind in kinds]).mean() for run in runs])


def interval(values: Floats) -> tuple[float, float, float]:
    """Return the mean of (seeds,) values and its 95 % interval: bootstrap over seeds."""
    rng = np.random.default_rng(0)
    drawn = values[rng.integers(len(values), size=(_DRAWS, len(values)))].mean(axis=1)
    low, high = np.quantile(drawn, [(1 - _LEVEL) / 2, (1 + _LEVEL) / 2])
    return float(values.mean()), float(low), float(high)


ONE_VIEW = (Kind.OPPONENT, Kind.TEAM_MATE, Kind.ONE_VIEW)
"""Kinds that hide a target in one view only."""


def compared(runs: Mapping[str, Sequence[Kept]], proposed: str) -> dict[str, float]:
    """
    Return the figures of trackers on the same seeds.

    Parameters
    ----------
    runs : mapping
        By name of a tracker, what it survived on each seed.
    proposed : str
        Whose lead over each other tracker is told, with its interval: paired over seeds.

    Returns
    -------
    dict
        ``<tracker>.kept`` of the occlusions in one view, ``<tracker>.<kind>.kept``,
        ``<tracker>.kept.low`` and ``.high``, ``lead.<other>``, ``.low`` and ``.high``.

    """
    figures: dict[str, float] = {}
    for name, each in runs.items():
        values = share(each, ONE_VIEW)
        figures |= with_interval(f'{name}.kept', values)
        for kind in Kind:
            figures[f'{name}.{kind}.kept'] = float(share(each, [kind]).mean())
        if name != proposed:
            lead = share(runs[proposed], ONE_VIEW) - values
            figures |= with_interval(f'lead.{name}', lead)
    return figures


def with_interval(name: str, values: Floats) -> dict[str, float]:
    """Return the mean of values and its interval, by name."""
    mean, low, high = interval(values)
    return {name: mean, f'{name}.low': low, f'{name}.high': high}
