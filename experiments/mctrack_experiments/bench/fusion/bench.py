"""The whole benchmark of fusion as figures with their protocol."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from mctrack_experiments.bench.fusion.accuracy import FRAMES, measure_accuracy
from mctrack_experiments.bench.fusion.hostile import (
    AFTER,
    BEFORE,
    SETTLED,
    SPOILED,
    measure_hostile,
)
from mctrack_experiments.bench.fusion.speed import measure_speed
from mctrack_experiments.bench.fusion.toolkit import WARM_UP, Toolkit, peer_version
from mctrack_experiments.bench.fusion.whole import measure_whole
from mctrack_experiments.bench.parts import Part
from mctrack_experiments.bench.workers import Progress
from mctrack_experiments.runs import listed
from mctrack_ros.evaluation.figures import Figures

ShowProgress = Callable[[str], AbstractContextManager[Progress]]


def bench_fusion(
    folder: Path,
    peers: Sequence[str],
    parts: Sequence[Part],
    seeds: Sequence[int],
    quick: bool,
    show: ShowProgress,
) -> Figures:
    """
    Measure fusion on the shared benchmark.

    Parameters
    ----------
    folder : Path
        Of the benchmark.
    peers : sequence of str
        Other trackers to be run beside.
    parts : sequence of Part
        What to measure.
    seeds : sequence of int
        Of the scenes on which accuracy is measured.
    quick : bool
        Time fewer ticks.
    show : callable
        Makes a progress bar of a title.

    Raises
    ------
    OSError
        If the benchmark is not in the folder.

    """
    Toolkit(folder)
    figures: dict[str, float] = {}
    if Part.SPEED in parts:
        with show('speed, scenes') as progress:
            figures |= measure_speed(folder, peers, quick=quick, progress=progress)
    if Part.WHOLE in parts:
        with show('whole tick, scenes') as progress:
            figures |= measure_whole(folder, quick=quick, progress=progress)
    if Part.ACCURACY in parts:
        with show('accuracy, scenes') as progress:
            figures |= measure_accuracy(folder, peers, seeds, progress=progress)
    protocol = _protocol(seeds) | {'peers': ', '.join(map(peer_version, peers)) or 'none'}
    if Part.HOSTILE in parts:
        with show('bad input, kinds') as progress:
            endured, failures = measure_hostile(folder, progress)
        figures |= endured
        protocol |= {'failed': failures} if failures else {}
    return Figures('bench_fusion', _command(parts, quick, bool(peers)), protocol, figures)


def _command(parts: Sequence[Part], quick: bool, beside: bool) -> str:
    """Return the command line that measures this again, on some seeds."""
    words = ['mctrack bench fusion']
    if set(parts) != set(Part):
        words += [f'--part {part}' for part in parts]
    return ' '.join(words + ['--quick'] * quick + ['--alone'] * (not beside))


def _protocol(seeds: Sequence[int]) -> dict[str, str]:
    return {
        't..c..': 'targets, cameras; three cameras see each point, twelve at t1000c20; time of '
        f'a core tick on one core, ours and the others in turns of 20 ticks in one process, the '
        f'first {WARM_UP} ticks left out; ratio: their median over ours; growth: median over '
        'that of 100 targets in the same run; cpu: the same in processor time',
        'base, crowd': f'25 targets, 5 cameras, density 1 and 4, {FRAMES} ticks of 40 ms, '
        f'{len(seeds)} scenes of each, of seeds {listed(seeds)}; the first {WARM_UP} '
        'ticks left out; gate 1 m; mean, least and most of the scenes; over_norfair: ours less '
        "norfair's on the same scene; position_error_ratio: over that of a Kalman filter told "
        'whose every detection is',
        'whole': '25 targets, 5 cameras that send looks, ids of their own, ids they were told and '
        'groups, as codec messages; fusion and encoding of all that is published; decoding and '
        'batching apart, medians',
        'hostile': f'25 targets, 5 cameras, {BEFORE} ticks good, {SPOILED} spoiled, {AFTER} good '
        'again; longest processor time of batching and fusing a tick from the first spoiled one '
        'on; refused: messages and detections counted as not used; mota_after: of the last '
        f'{SETTLED} ticks',
    }
