"""An explanation in plain words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mctrack_ros.explain.fates import fate_of, taker_of
from mctrack_ros.explain.history import TrackHistory
from mctrack_ros.interfaces import Candidates, Choice, Decisions, Explanation, Reason, TrackStatus

NEAR_M = 3.0
"""Distance up to which another track is named as a neighbour."""

COLUMNS = (
    *('camera', 'row', 'calls it', 'takes it for', 'off by m', 'distance²', 'clutter', 'colours'),
    *('doubt', 'cost', 'probability', 'what became of it'),
)
"""Of the table of candidates."""


def row_of(decisions: Decisions, track_id: int) -> int:
    """Return the row of a track, by what it is called after the tick or else before."""
    rows = np.flatnonzero(decisions.track_id == track_id)
    return int(rows[0] if len(rows) else np.flatnonzero(decisions.previous_id == track_id)[0])


def sentences(history: TrackHistory) -> list[str]:
    """Return what is to be said of the track at the instant asked about."""
    now, decisions = history.now, history.now.decisions
    row = row_of(decisions, history.track_id)
    said = [_headline(history, row), reason_of(decisions, row, history.cameras, now.candidates)]
    if not decisions.is_published[row]:
        why = f'nothing has supported it for {decisions.unsupported[row]:.2f} s'
        if decisions.missed[row] >= history.gone:
            why = (
                'cameras that should have seen it did not (log-odds of having gone '
                f'{decisions.missed[row]:.1f}, the limit is {history.gone:.1f})'
            )
        said.append(f'It is remembered, not published: {why}.')
    if decisions.group[row]:
        mates = decisions.track_id[decisions.group == decisions.group[row]].tolist()
        others = [one for one in mates if one != decisions.track_id[row]]
        said.append(f'It is in a group with {_names(others)}: no camera sees it apart.')
    said += _silent_cameras(history, int(decisions.track_id[row]))
    said += _neighbours(now, row)
    if not history.is_same:
        said.append(
            'Note: the bag recorded other tracks here than its detections give now: it was made '
            'with other settings (see --site), another version, or is not complete.'
        )
    return said


def candidate_rows(history: TrackHistory) -> list[tuple[str, ...]]:
    """Return the lines of the table: what was weighed for the track, camera by camera."""
    candidates, decisions = history.now.candidates, history.now.decisions
    track_id = decisions.track_id[row_of(decisions, history.track_id)]
    return [
        _candidate_row(candidates, row, history)
        for row in np.flatnonzero(candidates.track_id == track_id).tolist()
    ]


def course(history: TrackHistory) -> Iterator[str]:
    """Yield what changed for the track after the instant, a line each time."""
    before = None
    name = history.track_id
    for each in history.explanations[history.index :]:
        decisions = each.decisions
        if name not in decisions.track_id and name not in decisions.previous_id:
            return
        row = row_of(decisions, name)
        name = int(decisions.track_id[row])
        state = decisions.reason[row], decisions.group[row], name, decisions.is_published[row]
        if state != before and before is not None:
            text = reason_of(decisions, row, history.cameras, each.candidates)
            text += '' if decisions.is_published[row] else ' It is not published.'
            yield f'{history.seconds(each.stamp_ns):8.3f} s  track {name}: {text}'
        before = state


def reason_of(
    decisions: Decisions, row: int, cameras: tuple[str, ...], candidates: Candidates
) -> str:
    """Return why a track is as it is."""
    value, limit = float(decisions.value[row]), float(decisions.limit[row])
    name, other = int(decisions.track_id[row]), int(decisions.other_id[row])
    mine = candidates.select(candidates.track_id == name)
    seen_by = _cameras(int(decisions.cameras[row]), cameras)
    hidden_in = sorted({cameras[one] for one in mine.camera[mine.choice == Choice.HIDES].tolist()})
    beside = f' It parts from track {other}, whose past it shares.' if other else ''
    return {
        Reason.COASTS: (
            f'It coasts: nothing has supported it for {value:.2f} s; it ends after {limit:.2f} s.'
        ),
        Reason.SEEN: f'It is seen by {_list(seen_by)}.',
        Reason.HIDDEN: (
            f'No camera sees it; a detection of several people in {_list(hidden_in)} is taken to '
            'hide it, and keeps it alive.'
        ),
        Reason.BEGAN: (
            f'It begins: no track explains what {_list(seen_by)} saw. Its log-odds of being a '
            f'target are {value:.1f}, {limit:.1f} confirm it.{beside}'
        ),
        Reason.CONFIRMED: (
            f'It is confirmed: its log-odds of being a target are {value:.1f}, {limit:.1f} are '
            f'needed; seen by {_list(seen_by)}.{beside}'
        ),
        Reason.REAPPEARED: (
            f'It is found again: by place, motion, time and colours what began as track {other} '
            f'is rather {name}, who was lost, than somebody new (cost {value:.1f}, below '
            f'{limit:g}).'
        ),
        Reason.RECOGNISED: (
            f'Its id is corrected from {other} to {name}: since an encounter it might be either, '
            f'and its colours differ from those of {name} by {value:.2f}, from those of {other} '
            f'by {limit:.2f} (people differ from themselves by 1).'
        ),
        Reason.ABSORBED: (
            f'Track {other} is joined to it: they were near and hardly separable in images, or '
            f'it seemed one with a third while {other} began beside them.'
        ),
        Reason.SILENT: (
            f'It ends: nothing has supported it for {value:.2f} s, the limit is {limit:.2f} s.'
        ),
        Reason.UNSEEN: (
            f'It ends: its log-odds of being a target fell to {value:.1f}: cameras that should '
            'see it do not.'
        ),
        Reason.JOINED: (
            f'It ends: it followed the same target as track {other}, or the one that {other} had '
            'lost.'
        ),
        Reason.RESET: 'It ends: time stepped back, all begins anew.',
    }[Reason(decisions.reason[row])]


def _headline(history: TrackHistory, row: int) -> str:
    decisions = history.now.decisions
    x, y, _ = decisions.position[row].tolist()
    speed = float(np.hypot(*decisions.velocity[row]))
    name, called = int(decisions.track_id[row]), int(decisions.previous_id[row])
    status = TrackStatus(decisions.status[row]).name.lower()
    former = f' ({called} until then)' if called else ''
    return (
        f'Track {name}{former} at {history.seconds(decisions.stamp_ns):.3f} s '
        f'(stamp {decisions.stamp_ns * 1e-9:.3f}): {status}, at ({x:.2f}, {y:.2f}) m, '
        f'{speed:.1f} m/s, {decisions.age[row]:.1f} s old.'
    )


def _silent_cameras(history: TrackHistory, track_id: int) -> Iterator[str]:
    """Say of cameras that offer the track nothing what they show nearest to it."""
    candidates, decisions = history.now.candidates, history.now.decisions
    row = row_of(decisions, track_id)
    place = decisions.position[row, :2]
    for index, camera in enumerate(history.cameras):
        here = np.flatnonzero(candidates.camera == index)
        if (candidates.track_id[here] == track_id).any():
            continue
        if not len(here):
            yield f'{camera} has no detections in this tick.'
            continue
        gap = np.linalg.norm(candidates.position[here, :2] - place, axis=1)
        nearest = here[int(gap.argmin())]
        whose = taker_of(candidates, nearest) or 'nobody takes it'
        yield (
            f'{camera} offers nothing inside the gate; its nearest detection is '
            f'{gap.min():.1f} m away ({whose}).'
        )


def _neighbours(now: Explanation, row: int) -> Iterator[str]:
    decisions = now.decisions
    gap = np.linalg.norm(decisions.position[:, :2] - decisions.position[row, :2], axis=1)
    near = [one for one in np.argsort(gap).tolist() if one != row and gap[one] < NEAR_M]
    if near:
        near = [
            f'{decisions.track_id[one]} at {gap[one]:.2f} m '
            f'({Reason(decisions.reason[one]).name.lower().replace("_", " ")})'
            for one in near
        ]
        yield f'Near it: {_list(near)}.'


def _candidate_row(candidates: Candidates, row: int, history: TrackHistory) -> tuple[str, ...]:
    apart = candidates.position[row, :2] - candidates.expected[row]
    numbers = [float(np.hypot(*apart)), float(candidates.squared_distance[row])]
    names = ('clutter', 'appearance', 'doubt', 'cost')
    numbers += [float(getattr(candidates, name)[row]) for name in names]
    local_id, told_id = int(candidates.local_id[row]), int(candidates.told_id[row])
    weighed = np.isfinite(candidates.squared_distance[row]) and candidates.choice[row] < 3
    return (
        history.cameras[candidates.camera[row]],
        str(candidates.detection[row]),
        str(local_id) if local_id else '-',
        str(told_id) if told_id else '-',
        *(f'{number:.2f}' if np.isfinite(number) else '-' for number in numbers),
        f'{candidates.probability[row]:.3f}' if weighed else '-',
        fate_of(candidates, row, history.gate),
    )


def _cameras(bits: int, cameras: tuple[str, ...]) -> list[str]:
    return [name for index, name in enumerate(cameras) if bits >> index & 1]


def _names(ids: list[int]) -> str:
    return _list([f'track {one}' for one in ids]) if ids else 'others'


def _list(words: list[str]) -> str:
    """Return words as a sentence counts them up."""
    if not words:
        return 'no camera'
    return ', '.join(words[:-1]) + ' and ' + words[-1] if len(words) > 1 else words[0]
