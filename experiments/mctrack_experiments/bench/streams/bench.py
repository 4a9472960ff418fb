"""`mctrack bench streams`: bytes a second of each form, and what hostile readers cost fusion."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from mctrack_experiments.bench.store import RATE_HZ, TRACKS, track_tape
from mctrack_experiments.bench.streams.latency import CLIENTS, SEGMENT_S, measure_latency
from mctrack_experiments.bench.streams.sizes import SECONDS, measure_sizes
from mctrack_ros.evaluation.figures import Figures


def bench_streams(
    bag: Path, pairs: int = 24, tell: Callable[[str], None] = lambda line: None
) -> Figures:
    """
    Measure streams.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch.
    pairs : int
        How often fusion is measured with and without hostile readers; 0: not at all.
    tell : callable
        Told how far it is.

    """
    figures = measure_sizes(track_tape(bag))
    if pairs:
        figures |= measure_latency(bag, pairs, tell)
    return Figures(
        'bench_streams',
        'mctrack bench streams',
        {
            'tracks': TRACKS,
            'rate_hz': RATE_HZ,
            'seconds': SECONDS,
            'clients': f'{CLIENTS} on this machine at the lowest priority: never read, read a '
            'byte a second, garbage, endless headers, half requests, reconnections',
            'pairs': f'{pairs} of {SEGMENT_S:g} s without and with them, in turn first',
            'latency': "from the last camera's message to /tracks, 5 cameras, 25 players; the "
            'interval of 95 % is resampled by pairs',
            'priority': _priority(),
            'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
        },
        figures,
    )


def _priority() -> str:
    """Return how the scheduler weighs this session against others on the machine."""
    try:
        return Path('/proc/self/autogroup').read_text(encoding='ascii').split(' ', 1)[1].strip()
    except (OSError, IndexError):
        return 'as others'
