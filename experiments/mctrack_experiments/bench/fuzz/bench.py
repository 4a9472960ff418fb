"""Malformed messages: no crash, no wrong result, every refusal counted."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from mctrack_experiments.bench.fuzz.codec import fuzz_codec
from mctrack_experiments.bench.fuzz.live import BURST, fuzz_live
from mctrack_experiments.bench.workers import Progress
from mctrack_ros.evaluation.figures import Figures


def bench_fuzz(
    bag: Path,
    decoded: int,
    sent: int,
    domain: int | None,
    progress: Callable[[str], AbstractContextManager[Progress]],
) -> Figures:
    """
    Decode malformed messages, and send some into a running graph.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch.
    decoded, sent : int
        How many.
    domain : int or None
        ROS domain; None: that of the environment.
    progress : callable
        Title -> what is told how many of how many are done.

    """
    with progress('decoding, 5000 a step') as told:
        figures, faults = fuzz_codec(decoded, told)
    with progress('sending') as told:
        figures |= fuzz_live(bag, sent, domain, told)
    protocol = {
        'messages': 'sound ones with one to three changes by seed: header, fields, sizes, data, '
        'numbers, declared sizes, bits, cuts; half clouds of five kinds, half images and masks',
        'faults': faults
        or 'none; looked for: any exception but a refusal, a refusal that is not '
        'one line, rows that differ from the bytes that the message describes, an image of '
        'another size, a cut-off one that is taken',
        'growth_mb': 'of the process after its first 5000',
        'lines': 'written by libpng and OpenCV',
        'live': f'{BURST} a second each to detections, events, raw and compressed images of one '
        'camera, while four others are tracked; only such that the codec refuses',
        'uncounted': 'sent, but not among those refused on /diagnostics',
        'same_tracks': 'as a replay of the recording in lock step gives them',
    }
    return Figures('bench_fuzz', 'mctrack bench fuzz', protocol, figures)
