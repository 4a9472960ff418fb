"""What becomes of ids from cell to cell, and what each process costs, beside one fusion node."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.cells.play import (
    DELAY_MS,
    JITTER_MS,
    JOINED,
    play_cells,
    play_one,
    play_site,
)
from mctrack_experiments.bench.cells.site import (
    CELL_BIAS_M,
    CELLS,
    GAP_M,
    GRID,
    PEOPLE,
    SECONDS,
    TICK_S,
    CellSite,
    cell_site,
)
from mctrack_experiments.bench.fusion.adapter import reported
from mctrack_experiments.bench.workers import Progress, run_spread
from mctrack_experiments.runs import listed
from mctrack_experiments.scenarios.staged.playing import GATE_M
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.evaluation.frames import ground_distance, matched
from mctrack_ros.interfaces import Tracks

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

PERIOD_NS = round(TICK_S * 1e9)
APART_S, LONG_S, LATE_S = 3.0, 1.0, 8.0
"""From so long before and after a border on an id is looked at, over how long, and so late at
most, s: a cell needs its time to be sure of somebody whom one camera sees."""
BORDERS = ('overlap', 'gap')
WARM_UP = 150
"""First ticks that do not count: cells learn meanwhile where their cameras see."""


def bench_cells(
    seeds: Sequence[int], show: Callable[[str], AbstractContextManager[Progress]]
) -> Figures:
    """
    Count who keeps an id from cell to cell, and what processes cost.

    Parameters
    ----------
    seeds : sequence of int
        One site for each; they have 4, 6 and 8 cells in turn.
    show : callable
        Makes a progress bar of a title.

    """
    with show('cells, sites') as progress:
        measured = run_spread(site_figures, list(seeds), progress)
    counts = {name: np.array([each[name] for each in measured]) for name in measured[0]}
    figures: dict[str, float] = {}
    for name, values in counts.items():
        if name.startswith('count.'):
            figures[name.removeprefix('count.')] = float(values.sum())
        else:
            figures[name] = float(values.max() if name.endswith('worst') else values.mean())
    for who in ('cells', 'one'):
        for name in ('kept', 'at_once'):
            parts = [figures.pop(f'{who}.{border}.{name}_crossings') for border in BORDERS]
            wholes = [figures[f'{border}.crossings'] for border in BORDERS]
            for border, part, whole in zip(BORDERS, parts, wholes):
                figures[f'{who}.{border}.{name}'] = part / whole if whole else float('nan')
            figures[f'{who}.{name}'] = sum(parts) / sum(wholes)
    figures['cells.kept_least'] = min(
        (each['count.cells.overlap.kept_crossings'] + each['count.cells.gap.kept_crossings'])
        / max(each['count.overlap.crossings'] + each['count.gap.crossings'], 1)
        for each in measured
    )
    return Figures(
        'bench_cells',
        'mctrack bench cells',
        {
            'sites': f'seeds {listed(seeds)}: {GRID[0] * GRID[1]} cameras at {1 / TICK_S:g} Hz, '
            f'every second cell at half of that, {PEOPLE} people of three kits, {SECONDS:g} s; '
            f'{", ".join(map(str, CELLS))} cells in turn',
            'borders': f'cells overlap by 4 to 6 m; along one border nobody sees {GAP_M:g} m',
            'cells': f'their reports arrive {DELAY_MS[0]:g} to {DELAY_MS[1] + JITTER_MS:g} ms '
            f'late; their cameras are off by {CELL_BIAS_M:g} m, one standard deviation along each '
            'axis, beside what each camera is off by',
            'kept': f'share of crossings of a border after which the id is that of before, '
            f'in the last second with an id up to {APART_S:g} s before and the first from '
            f'{APART_S:g} s after; no id for {LATE_S:g} s is not kept',
            'at_once': f'the same where no id for {LONG_S:g} s is not kept',
            'one': 'one fusion node, all detections at the full rate and without delay; '
            f'{JOINED} of its cameras are four of the site each: it takes 32 at most',
            'ms': 'processor time of a tick of a process: fusion alone, without messages',
            'core': 'share of a core that takes at the rate of its ticks',
            'gate_m': f'{GATE_M:g}',
            'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
        },
        dict(sorted(figures.items())),
    )


def site_figures(seed: int) -> dict[str, float]:
    """Return the figures of one site."""
    site = cell_site(seed, list(CELLS)[seed % len(CELLS)])
    cells, arrivals = play_cells(site, seed)
    fused = play_site(arrivals, len(cells))
    one = play_one(site, seed)
    figures = {}
    for who, tracks in (('cells', fused.tracks), ('one', one.tracks)):
        ids = ids_of(site.paths, tracks)
        for border, crossings in crossings_of(site).items():
            figures[f'count.{border}.crossings'] = float(len(crossings))
            for name, within_s in (('kept', LATE_S), ('at_once', LONG_S)):
                kept = float(is_kept(ids, crossings, within_s).sum())
                figures[f'count.{who}.{border}.{name}_crossings'] = kept
        figures |= {f'{who}.{name}': value for name, value in scores_of(site, tracks).items()}
    for who, processes in (('cell', cells), ('site', [fused]), ('one', [one])):
        times = [np.array(process.milliseconds) for process in processes]
        loads = [each.sum() / 1e3 / SECONDS for each in times]
        figures |= {
            f'{who}.ms': float(np.mean([each.mean() for each in times])),
            f'{who}.p99_ms': float(np.mean([np.quantile(each, 0.99) for each in times])),
            f'{who}.core': float(np.mean(loads)),
            f'{who}.core_worst': float(max(loads)),
        }
    return figures


def ids_of(paths: Floats, instants: Sequence[Tracks]) -> Indices:
    """Return whose track had which id, (ticks, people); 0: none."""
    ids = np.zeros(paths.shape[:2], np.intp)
    for tracks in instants:
        frame = tracks.stamp_ns // PERIOD_NS - 1
        names, places = reported(tracks)
        people, rows = matched(ground_distance(paths[frame], places), GATE_M)
        ids[frame, people] = np.array(names, np.intp)[rows]
    return ids


def crossings_of(site: CellSite) -> dict[str, Indices]:
    """Return tick and person, (k, 2), of those who cross from cell to cell, by kind of border."""
    cell, reach = site.cell_of(site.paths), round((APART_S + LONG_S) / TICK_S)
    found: dict[str, list[tuple[int, int]]] = {'overlap': [], 'gap': []}
    gap_m = site.borders[0][0]
    for tick, person in np.argwhere(cell[1:] != cell[:-1]).tolist():
        first, last = tick + 1 - reach, tick + 1 + reach
        if first < WARM_UP or last > len(cell):
            continue
        before, after = cell[first : tick + 1, person], cell[tick + 1 : last, person]
        if (before == before[0]).all() and (after == after[0]).all():
            x = site.paths[[tick, tick + 1], person, 0]
            kind = 'gap' if x.min() <= gap_m < x.max() else 'overlap'
            found[kind].append((tick + 1, person))
    return {kind: np.array(each, np.intp).reshape(-1, 2) for kind, each in found.items()}


def is_kept(ids: Indices, crossings: Indices, within_s: float = LATE_S) -> NDArray[np.bool_]:
    """
    Return after which crossings, (k,), the id is that of before.

    Compared are the ids in the last second before that he had one, and in the first second after;
    who has none for so long is not kept.
    """
    apart, reach, late = (round(each / TICK_S) for each in (APART_S, LONG_S, within_s))
    kept = []
    for tick, person in crossings.tolist():
        before = ids[max(tick - apart - late, 0) : tick - apart, person]
        after = ids[tick + apart : tick + apart + late, person]
        had, has = np.flatnonzero(before), np.flatnonzero(after)
        kept.append(
            len(had) > 0
            and len(has) > 0
            and _usual(before[max(had[-1] - reach + 1, 0) : had[-1] + 1])
            == _usual(after[has[0] : has[0] + reach])
        )
    return np.array(kept, bool)


def _usual(ids: Indices) -> int:
    """Return the id that occurs most often; 0: none occurs."""
    counts = Counter(ids[ids > 0].tolist())
    return max(sorted(counts), key=counts.__getitem__, default=0)


def scores_of(site: CellSite, instants: Sequence[Tracks]) -> dict[str, float]:
    """Return scores on the ground after the warm-up."""
    last = [each for each in instants if each.stamp_ns // PERIOD_NS - 1 >= WARM_UP]
    tracks = Trajectories.from_tracks(last, PERIOD_NS, PERIOD_NS)
    ticks, people = site.paths.shape[:2]
    frame, person = np.divmod(np.arange(WARM_UP * people, ticks * people), people)
    truth = Trajectories(frame, person + 1, site.paths[frame, person])
    scores = evaluate_ground(truth, tracks, GATE_M)
    return {name: float(getattr(scores, name)) for name in ('mota', 'idf1', 'switches')}
