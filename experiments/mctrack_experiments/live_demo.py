"""`mctrack demo` over several matches: the median run, since one says little of live timing."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from mctrack_experiments.runs import medians
from mctrack_ros.cli.commands.demo import demo
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.report.targets import DEMO_TARGETS

SECONDS, CAMERAS = 60.0, 5


def reproduce_demo(
    seeds: Sequence[int], progress: Callable[[str], None] = lambda line: None
) -> Figures:
    """
    Track matches live, one after the other; it needs two idle cores.

    Parameters
    ----------
    seeds : sequence of int
        One match each.
    progress : callable
        Told what is being done.

    """
    runs = []
    for seed in seeds:
        progress(f'seed {seed}: {SECONDS:g} s live')
        with tempfile.TemporaryDirectory() as scratch:
            out = Path(scratch) / 'demo'
            demo(SECONDS, CAMERAS, False, seed, out, None, None, show_map=False)
            runs.append(Figures.read(out / 'summary.json'))
    return median_run(runs, seeds)


def median_run(runs: Sequence[Figures], seeds: Sequence[int]) -> Figures:
    """Return the medians of figures over runs, and the extremes of those that have a target."""
    with_target = {target.figure for target in DEMO_TARGETS}
    figures = medians([run.figures for run in runs], with_target)
    protocol = {name: value for name, value in runs[0].protocol.items() if name != 'seed'}
    protocol |= {
        'seeds': ', '.join(map(str, seeds)),
        'figures': f'medians of {len(runs)} runs, each figure by itself; least, most: of them',
    }
    return Figures('demo', 'mctrack reproduce demo', protocol, figures)
