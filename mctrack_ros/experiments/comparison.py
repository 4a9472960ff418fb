"""Tracks in a file against truth in a file: what `mctrack evaluate` does."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mctrack_ros.evaluation import Trajectories, evaluate_ground, identity_switches
from mctrack_ros.experiments.common_origin import common_origin, retold
from mctrack_ros.experiments.figures import Figures
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import (
    BagError,
    BagReader,
    frame_origin_ns,
    read_mot_text,
    stated_origin,
)
from mctrack_ros.stated_origin import Origin

TRUTH_TOPIC = '/truth/tracks'
TRACKS_TOPIC = '/tracks'
_TEXT_PERIOD_NS = 40_000_000
_SAME_PERIOD = 0.01


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


def read_instants(
    path: str | Path, topics: tuple[str, ...], origin: Origin | None = None
) -> Recording:
    """
    Read the first of some topics that a bag has, or MOT text.

    Parameters
    ----------
    path : str or Path
        A bag's folder, or a file of MOT text with ground positions.
    topics : tuple of str
        Which hold `Tracks`, the preferred first.
    origin : (float, float), optional
        What positions are told from, m; unless given, as a bag tells them, and text from zero.

    Raises
    ------
    BagError, MotTextError
        If the file cannot be read, or holds none of the topics.

    """
    if Path(path).is_file():
        text = read_mot_text(path, _TEXT_PERIOD_NS, origin=origin or (0.0, 0.0))
        return Recording(tuple(text), True)
    with BagReader(path) as reader:
        present = [topic for topic in topics if topic in reader.topics]
        if not present:
            raise BagError(f'{path} has no topic {" or ".join(topics)}')
        instants = [rows for rows, _ in reader.rows(present[0], Tracks)]
        instants = retold(instants, stated_origin(reader), origin)
    return Recording(tuple(sorted(instants, key=lambda rows: rows.stamp_ns)), False)


@dataclass(frozen=True, eq=False, slots=True)
class Comparison:
    """
    Tracks beside truth, frame by frame.

    Attributes
    ----------
    truth_path, tracks_path : str or Path
        Where they come from.
    truth, tracks : Trajectories
        In common frames.
    seconds : dict of int to float
        Of each frame that has tracks, since the first one that has, s.
    note : str
        What is to be said of their periods; empty: they are the same.
    origin : (float, float)
        What positions of both are told from, m.

    """

    truth_path: str | Path
    tracks_path: str | Path
    truth: Trajectories
    tracks: Trajectories
    seconds: dict[int, float]
    note: str = ''
    origin: Origin = (0.0, 0.0)

    @classmethod
    def read(cls, truth: str | Path, tracks: str | Path) -> Comparison:
        """
        Read both.

        Instants of two bags fall together by their stamps. Where one of the two is text, its
        first frame is the first instant of the other. Positions are told from `common_origin`.

        Parameters
        ----------
        truth : str or Path
            A bag with ``/truth/tracks`` (or ``/tracks``), or MOT text.
        tracks : str or Path
            A bag with ``/tracks``, MOT text, or the folder that `mctrack track` wrote.

        Raises
        ------
        BagError, MotTextError
            If a file cannot be read.
        ValueError
            If the two have no instant in common, or tracks come faster than truth.

        """
        truth, tracks = _file_in(truth), _file_in(tracks)
        origin = common_origin((truth, tracks))
        true = read_instants(truth, (TRUTH_TOPIC, TRACKS_TOPIC), origin)
        found = read_instants(tracks, (TRACKS_TOPIC,), origin)
        period_ns = found.period_ns if true.is_text else true.period_ns
        first = true if true.instants and not true.is_text else found
        origin_ns = _origin_ns(first, period_ns)
        true_rows = _trajectories(true, period_ns, origin_ns)
        note = _note(true, found)
        try:
            rows = _trajectories(found, period_ns, origin_ns)
        except ValueError as error:
            raise ValueError(f'{tracks}: {error} {note}'.rstrip()) from error
        if len(rows) and not np.isin(rows.frame, true_rows.frame).any():
            raise ValueError(
                f'{tracks} and {truth} have no instant in common: if the recording was played '
                'with new stamps, compare with the truth that was recorded beside it'
            )
        stamps = np.array([each.stamp_ns for each in found.instants], np.int64)
        if found.is_text:
            period_ns, origin_ns = _TEXT_PERIOD_NS, 0
        frames = ((stamps - origin_ns) // period_ns).tolist()
        seconds = dict(zip(frames, ((stamps - stamps[:1]) * 1e-9).tolist()))
        return cls(truth, tracks, true_rows, rows, seconds, note, origin)

    def figures(self, gate_m: float) -> Figures:
        """Return the scores; a match is at most so far apart, m."""
        return Figures(
            name='evaluate',
            command=f'mctrack evaluate {self.truth_path} {self.tracks_path} --gate {gate_m:g}',
            protocol={
                'gate_m': gate_m,
                'frames with truth': len(np.unique(self.truth.frame)),
                'rows': 'confirmed, coasting and grouped tracks',
            },
            figures=evaluate_ground(self.truth, self.tracks, gate_m).figures(),
        )

    def switch_lines(self, gate_m: float) -> list[str]:
        """
        Return what to say of the identity switches.

        Where the tracks are a bag, each is followed by how to ask why: of the old track from when
        it was last matched, and of the new one.
        """
        switches = identity_switches(self.truth, self.tracks, gate_m)
        is_bag = Path(self.tracks_path).is_dir()
        lines = []
        for row in range(len(switches)):
            old, new = int(switches.old_id[row]), int(switches.new_id[row])
            before = self.seconds[int(switches.last_frame[row])]
            at = self.seconds[int(switches.frame[row])]
            x, y = (switches.position[row] + np.array(self.origin)).tolist()
            lines.append(
                f'{at:9.2f} s  {switches.truth_id[row]} was {old} (until {before:.2f} s), '
                f'is {new}, at ({x:.1f}, {y:.1f}) m'
            )
            if is_bag:
                ask = f'             mctrack explain {self.tracks_path} --track'
                lines.append(f'{ask} {old} --at {before:.2f} --for {at - before:.2f}')
                lines.append(f'{ask} {new} --at {at:.2f}')
        return lines


def compare(truth: str | Path, tracks: str | Path, gate_m: float = 1.0) -> Figures:
    """
    Score tracks against truth on the ground plane; see `Comparison`.

    Parameters
    ----------
    truth, tracks : str or Path
        Bags, or MOT text.
    gate_m : float
        Largest distance of a match, m.

    Raises
    ------
    BagError, MotTextError
        If a file cannot be read.
    ValueError
        If the two have no instant in common.

    """
    return Comparison.read(truth, tracks).figures(gate_m)


def _file_in(path: str | Path) -> str | Path:
    """Return the bag in a folder that `mctrack track` wrote; else what was given."""
    bag = Path(path) / 'bag'
    return bag if not (Path(path) / 'metadata.yaml').exists() and bag.is_dir() else path


def _note(truth: Recording, tracks: Recording) -> str:
    """Return what is to be said of two bags whose instants come at different rates."""
    true_ms, found_ms = truth.period_ns * 1e-6, tracks.period_ns * 1e-6
    if truth.is_text or tracks.is_text or abs(found_ms / true_ms - 1) < _SAME_PERIOD:
        return ''
    return (
        f'(truth comes every {true_ms:g} ms, tracks every {found_ms:g} ms: a frame is '
        f'{true_ms:g} ms long, and where one has no rows, those of the other count as '
        'missed or false)'
    )


def _origin_ns(recording: Recording, period_ns: int) -> int:
    if recording.is_text or not recording.instants:
        return 0
    return frame_origin_ns(recording.instants[0].stamp_ns, period_ns)


def _trajectories(recording: Recording, period_ns: int, origin_ns: int) -> Trajectories:
    if recording.is_text:
        period_ns, origin_ns = _TEXT_PERIOD_NS, 0
    return Trajectories.from_tracks(recording.instants, period_ns, origin_ns)
