"""Tracks in a file against truth in a file: what `mctrack evaluate` does."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.experiments.figures import Figures
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagError, BagReader, frame_origin_ns, read_mot_text

TRUTH_TOPIC = '/truth/tracks'
TRACKS_TOPIC = '/tracks'
_TEXT_PERIOD_NS = 40_000_000


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """
    The instants of a bag or of MOT text.

    Attributes
    ----------
    instants : tuple of Tracks
        Ascending.
    is_text : bool
        Whether the file has frames instead of stamps; frame 1 then begins at 0 ns.

    """

    instants: tuple[Tracks, ...]
    is_text: bool

    @property
    def period_ns(self) -> int:
        """Time between instants, ns."""
        stamps = [rows.stamp_ns for rows in self.instants]
        if self.is_text or len(stamps) < 2:
            return _TEXT_PERIOD_NS
        return int(np.median(np.diff(stamps)))


def read_instants(path: str | Path, topics: tuple[str, ...]) -> Recording:
    """
    Read the first of some topics that a bag has, or MOT text.

    Parameters
    ----------
    path : str or Path
        A bag's folder, or a file of MOT text with ground positions.
    topics : tuple of str
        Which hold `Tracks`, the preferred first.

    Raises
    ------
    BagError, MotTextError
        If the file cannot be read, or holds none of the topics.

    """
    if Path(path).is_file():
        return Recording(tuple(read_mot_text(path, _TEXT_PERIOD_NS)), True)
    with BagReader(path) as reader:
        present = [topic for topic in topics if topic in reader.topics]
        if not present:
            raise BagError(f'{path} has no topic {" or ".join(topics)}')
        instants = [rows for rows, _ in reader.rows(present[0], Tracks)]
    return Recording(tuple(sorted(instants, key=lambda rows: rows.stamp_ns)), False)


def compare(truth: str | Path, tracks: str | Path, gate_m: float = 1.0) -> Figures:
    """
    Score tracks against truth on the ground plane.

    Instants of two bags fall together by their stamps. Where one of the two is text, its first
    frame is the first instant of the other.

    Parameters
    ----------
    truth : str or Path
        A bag with ``/truth/tracks`` (or ``/tracks``), or MOT text.
    tracks : str or Path
        A bag with ``/tracks``, or MOT text.
    gate_m : float
        Largest distance of a match, m.

    Raises
    ------
    BagError, MotTextError
        If a file cannot be read.
    ValueError
        If the two have no instant in common.

    """
    true = read_instants(truth, (TRUTH_TOPIC, TRACKS_TOPIC))
    found = read_instants(tracks, (TRACKS_TOPIC,))
    period_ns = found.period_ns if true.is_text else true.period_ns
    first = true if true.instants and not true.is_text else found
    origin_ns = _origin_ns(first, period_ns)
    true_rows = _trajectories(true, period_ns, origin_ns)
    rows = _trajectories(found, period_ns, origin_ns)
    if len(rows) and not np.isin(rows.frame, true_rows.frame).any():
        raise ValueError(
            f'{tracks} and {truth} have no instant in common: if the recording was played with '
            'new stamps, compare with the truth that was recorded beside it'
        )
    return Figures(
        name='evaluate',
        command=f'mctrack evaluate {truth} {tracks} --gate {gate_m:g}',
        protocol={
            'gate_m': gate_m,
            'frames': len(np.unique(true_rows.frame)),
            'rows': 'confirmed, coasting and grouped tracks',
        },
        figures=evaluate_ground(true_rows, rows, gate_m).figures(),
    )


def _origin_ns(recording: Recording, period_ns: int) -> int:
    if recording.is_text or not recording.instants:
        return 0
    return frame_origin_ns(recording.instants[0].stamp_ns, period_ns)


def _trajectories(recording: Recording, period_ns: int, origin_ns: int) -> Trajectories:
    if recording.is_text:
        period_ns, origin_ns = _TEXT_PERIOD_NS, 0
    return Trajectories.from_tracks(recording.instants, period_ns, origin_ns)
