"""The trajectory stream, as XML and as JSON: the same values under the same names."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import NO_CAMERA, ClassCode, EventCode, Events, Tracks, TrackStatus
from mctrack_ros.streams.formats.text import attribute
from mctrack_ros.streams.frames import About, Frame, groups_of

NAMESPACE = 'urn:mctrack:trajectory:1'
VERSION = 1
_UPPER = np.triu_indices(4)
_PLACES, _SPEEDS, _SHARES = 3, 2, 2
"""Decimals of positions, m, velocities, m/s, and probabilities."""
_CLASSES = {int(code): code.name.lower() for code in ClassCode}
_STATUSES = {int(code): code.name.lower() for code in TrackStatus}
_EVENTS = {int(code): code.name.lower() for code in EventCode}
_ELEMENTS = {
    'tracks': 'track',
    'groups': 'group',
    'events': 'event',
    'corrections': 'correction',
}
"""Lists of a frame, and what one of each is called in XML."""


def about_values(about: About) -> dict[str, Any]:
    """Return what is said once of a stream."""
    return {
        'version': VERSION,
        'run': about.run,
        'frame_id': about.frame_id,
        'origin': list(about.origin),
    }


def frame_values(frame: Frame) -> dict[str, Any]:
    """Return the values of a frame; what is not known is None."""
    values: dict[str, Any] = {'stamp_ns': frame.stamp_ns, 'tracks': list(_tracks(frame.tracks))}
    groups = groups_of(frame.tracks)
    if groups:
        listed = [{'id': group, 'members': members} for group, members in groups.items()]
        values['groups'] = listed
    for events in frame.events:
        for row, code in enumerate(events.event.tolist()):
            if code == EventCode.CORRECTION:
                values.setdefault('corrections', []).append(_correction(events, row))
            else:
                values.setdefault('events', []).append(_event(events, row, frame))
    return values


def xml_head(about: About) -> str:
    """Return the beginning of a document."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<trajectories xmlns="{NAMESPACE}"{_attributes(about_values(about))}>\n'
    )


def xml_frame(frame: Frame) -> str:
    """Return a frame as an element."""
    values = frame_values(frame)
    parts = [f'<frame stamp_ns="{values["stamp_ns"]}">']
    for name, element in _ELEMENTS.items():
        parts += [f'<{element}{_attributes(each)}/>' for each in values.get(name, ())]
    return ''.join(parts) + '</frame>\n'


XML_TAIL = '</trajectories>\n'


def json_head(about: About) -> str:
    """Return the first line."""
    return json.dumps(about_values(about)) + '\n'


def json_frame(frame: Frame) -> str:
    """Return a frame as a line."""
    return json.dumps(frame_values(frame), separators=(',', ':')) + '\n'


def _tracks(tracks: Tracks) -> Iterator[dict[str, Any]]:
    """Yield the values of each track."""
    columns = zip(
        tracks.track_id.tolist(),
        tracks.class_id.tolist(),
        tracks.status.tolist(),
        rounded(tracks.position, _PLACES),
        rounded(tracks.velocity, _SPEEDS),
        tracks.covariance[:, _UPPER[0], _UPPER[1]].tolist(),
        rounded(tracks.score, _SHARES),
        tracks.group.tolist(),
        tracks.member_count.tolist(),
    )
    for track, class_id, status, position, velocity, covariance, score, group, count in columns:
        values = {
            'id': track,
            'class': _CLASSES.get(class_id, str(class_id)),
            'status': _STATUSES.get(status, str(status)),
            'position': position,
            'velocity': velocity,
            'covariance': [float(f'{value:.3g}') for value in covariance],
            'score': score,
        }
        if group:
            values['group'] = group
        if count != 1:
            values['members'] = count
        yield values


def _event(events: Events, row: int, frame: Frame) -> dict[str, Any]:
    values = {
        'code': event_name(int(events.event[row])),
        'stamp_ns': events.stamp_ns,
        'track': int(events.track_id[row]),
        'others': events.others[row][events.others[row] > 0].tolist(),
        'zone': int(events.zone[row]),
        'zone_name': frame.zone_name(int(events.zone[row])),
    }
    values = {name: value for name, value in values.items() if value not in (0, [], '')}
    if events.old_id[row] or events.new_id[row]:
        values |= {'old': int(events.old_id[row]), 'new': int(events.new_id[row])}
    values['probability'] = rounded(events.probability[row], _SHARES)
    if events.camera[row] != NO_CAMERA:
        values['camera'] = int(events.camera[row])
    if np.isfinite(events.position[row]).all():
        values['position'] = rounded(events.position[row], _PLACES)
    return values


def _correction(events: Events, row: int) -> dict[str, Any]:
    return {
        'stamp_ns': events.stamp_ns,
        'old': int(events.old_id[row]),
        'new': int(events.new_id[row]),
        'probability': rounded(events.probability[row], _SHARES),
    }


def event_name(code: int) -> str:
    """Return the name of an event; one that is not known has its number."""
    return _EVENTS.get(code, f'code_{code}')


def rounded(values: NDArray[Any], decimals: int) -> Any:
    """Return numbers as lists, rounded; what is not finite is None."""
    near = np.round(np.asarray(values, np.float64), decimals) + 0.0  # no -0.0
    if not np.isfinite(near).all():
        known = np.isfinite(near)
        near = near.astype(object)
        near[~known] = None
    return near.tolist()


def _attributes(values: Mapping[str, Any]) -> str:
    return ''.join(f' {name}={_quoted(value)}' for name, value in values.items())


def _quoted(value: Any) -> str:
    if isinstance(value, list):
        return f'"{" ".join("NaN" if each is None else repr(each) for each in value)}"'
    if isinstance(value, str):
        return attribute(value)
    return f'"{"NaN" if value is None else value!r}"'
