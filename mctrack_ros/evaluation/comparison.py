"""Tracks in a file against truth in a file: what `mctrack evaluate` does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation import Trajectories, evaluate_ground, identity_switches
from mctrack_ros.evaluation.common_origin import common_origin
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.evaluation.instants import TRACKS_TOPIC, TRUTH_TOPIC, Recording, read_instants
from mctrack_ros.evaluation.selection import Selection, of_class, says_classes
from mctrack_ros.interfaces import REPORTED, ClassCode
from mctrack_ros.site.stated_origin import Origin

EVERYTHING = Selection()
_SAME_PERIOD = 0.01  # share by which periods may differ and count as equal


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
    begin_ns, period_ns : int
        When frame 0 is, after the beginning of the tracks, and how long a frame is, ns.
    selection : Selection
        Which rows they are.
    note : str
        What is to be said of them; empty: nothing.
    origin : (float, float)
        Origin of both positions, m.

    """

    truth_path: str | Path
    tracks_path: str | Path
    truth: Trajectories
    tracks: Trajectories
    begin_ns: int
    period_ns: int
    selection: Selection = EVERYTHING
    note: str = ''
    origin: Origin = (0.0, 0.0)

    @classmethod
    def read(
        cls,
        truth: str | Path,
        tracks: str | Path,
        selection: Selection = EVERYTHING,
        rate_hz: float | None = None,
    ) -> Comparison:
        """
        Read both.

        Instants fall together by their stamps, where both count from 1970. Else time 0, and the
        beginning of frame 1, is where the first period of the other begins.

        Parameters
        ----------
        truth : str or Path
            A bag with ``/truth/tracks`` (or ``/tracks``), MOT text, or a table with a header.
        tracks : str or Path
            A bag with ``/tracks``, text likewise, or the folder that `mctrack track` wrote.
        selection : Selection
            Which rows count.
        rate_hz : float, optional
            Frames a second of text; unless given, as many as the other file's, else 25.

        Raises
        ------
        BagError, MotTextError, TableError
            If a file cannot be read.
        ValueError
            If the two have no instant in common, or tracks come faster than truth, or nothing of
            the truth is left, or the tracks do not say their class.

        """
        truth, tracks = _file_in(truth), _file_in(tracks)
        origin = common_origin((truth, tracks))
        true = read_instants(truth, (TRUTH_TOPIC, TRACKS_TOPIC), rate_hz, origin)
        found = read_instants(tracks, (TRACKS_TOPIC,), rate_hz, origin)
        true, found = _on_one_clock(true, found, truth), _on_one_clock(found, true, tracks)
        if not rate_hz and true.counts_frames != found.counts_frames:
            true, found = (
                each.with_period(other.period_ns) if each.counts_frames else each
                for each, other in ((true, found), (found, true))
            )
        first = true if true.instants and true.is_absolute else found
        period_ns, origin_ns = true.period_ns, first.origin_ns()
        note = _note(true, found)
        own_ns = origin_ns if found.is_absolute else 0
        begin_ns = own_ns + period_ns // 2 - found.begin_ns()
        true, found, said = _of_class(true, found, selection.class_id, (truth, tracks))
        try:
            true_rows = _truth(_selected(true, selection, origin), period_ns, origin_ns)
            rows = _selected(found, selection, origin).trajectories(period_ns, origin_ns)
        except ValueError as error:
            raise ValueError(f'{tracks}: {error} {note}'.rstrip()) from error
        both = cls(
            truth,
            tracks,
            true_rows,
            rows,
            begin_ns,
            period_ns,
            selection,
            f'{note} {said}'.strip(),
            origin,
        )
        both._check_common()
        return both._in_span()

    def _check_common(self) -> None:
        """Refuse two recordings that have no instant in common."""
        both = len(self.tracks) and len(self.truth)
        if both and not np.isin(self.tracks.frame, self.truth.frame).any():
            raise ValueError(
                f'{self.tracks_path} and {self.truth_path} have no instant in common: if the '
                'recording was played with new stamps, compare with the truth that was '
                'recorded beside it'
            )

    def _in_span(self) -> Comparison:
        """Return what lies in the time that is selected."""
        kept = [
            rows.select(self.selection.in_span(self.seconds(rows.frame), self.period_ns * 1e-9))
            for rows in (self.truth, self.tracks)
        ]
        if not len(kept[0]):
            said = self.selection.options().strip()
            raise ValueError(f'{self.truth_path}: no truth is left{" by " + said if said else ""}')
        return replace(self, truth=kept[0], tracks=kept[1])

    def seconds(self, frame: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return when frames are, s since the tracks begin."""
        return np.asarray((self.begin_ns + frame * self.period_ns) * 1e-9, np.float64)

    def figures(self, gate_m: float) -> Figures:
        """Return the scores; a match is at most so far apart, m."""
        return Figures(
            name='evaluate',
            command=f'mctrack evaluate {self.truth_path} {self.tracks_path} --gate {gate_m:g}'
            + self.selection.options(),
            protocol={
                'gate_m': gate_m,
                **self.selection.protocol(),
                'frame_ms': round(self.period_ns * 1e-6, 3),
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
            frames = np.array([switches.last_frame[row], switches.frame[row]])
            before, at = self.seconds(frames).tolist()
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
    """Return what is to be said of two recordings whose instants come at different rates."""
    true_ms, found_ms = truth.period_ns * 1e-6, tracks.period_ns * 1e-6
    if abs(found_ms / true_ms - 1) < _SAME_PERIOD:
        return ''
    return (
        f'(truth comes every {true_ms:g} ms, tracks every {found_ms:g} ms: a frame is '
        f'{true_ms:g} ms long, and where one has no rows, those of the other count as '
        'missed or false)'
    )


def _on_one_clock(recording: Recording, other: Recording, path: str | Path) -> Recording:
    """
    Return a recording that can be laid beside the other.

    A table whose times count from 1970 does not say when its recording began: beside a file that
    does not count so its frames do.
    """
    if not recording.is_text or not recording.is_absolute or other.is_absolute:
        return recording
    if not recording.frames:
        raise ValueError(
            f'{path} has times since 1970 and the other file has not: give it a column frame, '
            'or both the same kind of times'
        )
    return recording.by_frames()


def _of_class(
    truth: Recording,
    tracks: Recording,
    code: ClassCode | None,
    paths: tuple[str | Path, str | Path],
) -> tuple[Recording, Recording, str]:
    """Return who is of a class, and what is to be said where the truth does not say who is."""
    if code is None:
        return truth, tracks, ''
    if not says_classes(tracks.instants):
        raise ValueError(
            f'{paths[1]} does not say the class of its tracks: give the bag, or the tracks.csv '
            'beside tracks.txt'
        )
    tracks = replace(tracks, instants=of_class(tracks.instants, code))
    if not says_classes(truth.instants):
        said = f'(the truth says no classes: all of it is taken for {code.name.lower()})'
        return truth, tracks, said
    return replace(truth, instants=of_class(truth.instants, code)), tracks, ''


def _selected(recording: Recording, selection: Selection, origin: Origin) -> Recording:
    return replace(recording, instants=selection.of_area(recording.instants, origin))


def _truth(chosen: Recording, period_ns: int, origin_ns: int) -> Trajectories:
    """Return the truth; of text, rows of score 0 are to be ignored, as in the MOTChallenge."""
    rows = chosen.trajectories(period_ns, origin_ns)
    if not chosen.is_text:
        return rows
    reported = [each.select(np.isin(each.status, REPORTED)).score for each in chosen.instants]
    return replace(rows, ignore=np.concatenate([np.ones(0), *reported]) == 0)
