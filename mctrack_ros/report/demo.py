"""What the demo gave: figures, a page, a video and text, of a match tracked live or offline."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros.evaluation import Scores, evaluate_ground, ground_timeline
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import GroundMapping
from mctrack_ros.recording import write_mot_text
from mctrack_ros.report import (
    Session,
    drops_of,
    load_session,
    write_birdseye,
    write_report,
)

GATE_M = 1.0
"""Of the comparison with truth."""

START_S = 2.0
"""What is late or dropped before this does not count: processes find one another."""


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """
    What is demonstrated.

    Attributes
    ----------
    seconds : float
        Length of the match, s.
    cameras : int
        How many of the site's cameras.
    offline : bool
        Whether the bag is tracked in lock step instead of live.
    seed : int
        Of the simulation.
    out : Path
        Folder of the results.

    """

    seconds: float = 120.0
    cameras: int = 5
    offline: bool = False
    seed: int = 1
    out: Path = Path('out/demo')

    @property
    def source(self) -> Path:
        """The rendered bag."""
        return self.out / 'source'

    @property
    def recorded(self) -> Path:
        """The bag with what was made of it."""
        return self.out / 'bag'

    @property
    def database(self) -> Path:
        """The trajectory database of the tracks."""
        return self.out / 'tracks.db'

    @property
    def command(self) -> str:
        """The command line of these options."""
        words = ['mctrack demo', f'--seconds {self.seconds:g}']
        words += [f'--cameras {self.cameras}'] if self.cameras != 5 else []
        words += [f'--seed {self.seed}'] if self.seed != 1 else []
        words += ['--offline'] if self.offline else []
        return ' '.join(words)


def evaluate_demo(
    options: DemoOptions,
    mappings: Sequence[GroundMapping] = (),
    wall_seconds: float | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Figures:
    """
    Evaluate the recorded bag against the source's truth and write everything into the folder.

    Writes ``summary.json``, ``report.html``, ``birdseye.webm``, ``tracks.txt``, ``truth.txt``.

    Parameters
    ----------
    options : DemoOptions
        Where the bags are.
    mappings : sequence of GroundMapping
        The cameras', for the video.
    wall_seconds : float, optional
        How long tracking took; by default the recording's own time.
    settings : mapping, optional
        What the site was set to, for the page.
    progress : callable
        Told how much of the video is written.

    Raises
    ------
    BagError
        If a bag cannot be read, or lacks a topic.

    """
    session = load_session(options.source, options.recorded)
    truth, tracks = session.trajectories()
    scores = evaluate_ground(truth, tracks, GATE_M)
    duplicates = int(ground_timeline(truth, tracks, GATE_M).duplicates.sum())
    figures = Figures(
        name='demo',
        command=options.command,
        protocol=_protocol(options, session),
        figures=_quality(scores, duplicates) | _timing(session, wall_seconds) | _losses(session),
    )
    figures.write(options.out / 'summary.json')
    origin_ns = session.start_ns
    write_mot_text(options.out / 'tracks.txt', session.tracks, session.period_ns, origin_ns)
    write_mot_text(options.out / 'truth.txt', session.truth, session.period_ns, origin_ns)
    write_report(options.out / 'report.html', session, figures, GATE_M, settings or {})
    write_birdseye(options.out / 'birdseye.webm', session, mappings, progress)
    return figures


def _protocol(options: DemoOptions, session: Session) -> dict[str, Any]:
    return {
        'gate_m': GATE_M,
        'frames': len(session.truth),
        'seconds': session.duration_s,
        'area': 'the whole pitch',
        'seed': options.seed,
        'cameras': options.cameras,
        'mode': 'offline, in lock step' if options.offline else 'live, over DDS',
        'late_and_dropped': f'counted after the first {START_S:g} s',
        'latency': 'capture stamp to reception of /tracks, all ticks',
    }


def _quality(scores: Scores, duplicates: int) -> dict[str, float]:
    return {
        'mota': scores.mota,
        'idf1': scores.idf1,
        'hota': scores.hota,
        'moda': scores.moda,
        'position_error_m': scores.mean_distance,
        'switches': scores.switches,
        'false_positives': scores.false_positives,
        'duplicates': duplicates,
        'ghosts': scores.false_positives - duplicates,
        'misses': scores.misses,
        'fragmentations': scores.fragmentations,
        'precision': scores.precision,
        'recall': scores.recall,
    }


def _timing(session: Session, wall_seconds: float | None) -> dict[str, float]:
    """Return latency and pace; offline there is no latency."""
    latency = session.latency_ms() if wall_seconds is None else np.full(1, np.nan)
    late = [float(np.percentile(latency, percent)) for percent in (50, 99, 100)]
    stamps = [rows.stamp_ns for rows in session.tracks]
    if wall_seconds is None:
        factor = (stamps[-1] - stamps[0]) / float(session.logged_ns[-1] - session.logged_ns[0])
    else:
        factor = session.duration_s / wall_seconds
    return {
        'latency_p50_ms': late[0],
        'latency_p99_ms': late[1],
        'latency_max_ms': late[2],
        'realtime_factor': factor,
    }


def _losses(session: Session) -> dict[str, float]:
    drops = drops_of(session.ticks, session.start_ns, len(session.cameras))
    return {
        'ticks': len(session.tracks),
        'ticks_expected': len(session.truth),
        'late_ticks': drops.late_ticks(START_S),
        'late_ticks_at_start': drops.late_ticks() - drops.late_ticks(START_S),
        'dropped_detections': drops.total('dropped_detections', START_S),
        'dropped_detections_at_start': drops.total('dropped_detections')
        - drops.total('dropped_detections', START_S),
        'missing_images': drops.total('missing'),
        'feedback_missed': drops.total('feedback_missed'),
    }
