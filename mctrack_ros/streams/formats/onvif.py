"""
The stream as ONVIF metadata: `tt:MetadataStream`, and JSON for an event broker.

A frame is built once, as ONVIF's rules for JSON say (Core Specification, annex E): attributes
begin with @, text is #text, repeated elements are lists; the same values are written as XML.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from mctrack_ros.interfaces import REPORTED, ClassCode, EventCode, Events, Tracks
from mctrack_ros.streams.formats.geo import GeoReference
from mctrack_ros.streams.formats.text import attribute, utc
from mctrack_ros.streams.formats.trajectory import event_name, rounded
from mctrack_ros.streams.frames import Frame, groups_of

VENDOR = 'urn:mctrack:onvif:1'
"""Namespace of what ONVIF has no word for."""
SOURCE = 'mctrack'
"""Name of the analytics module."""
PROFILE = 'ground'
"""Token of the profile and of the video source: not a camera but the ground that all see."""
GROUP_IDS = 1 << 31
"""Object ids of groups begin here; those of tracks lie below."""
XML_HEAD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<tt:MetadataStream xmlns:tt="http://www.onvif.org/ver10/schema" '
    'xmlns:wsnt="http://docs.oasis-open.org/wsn/b-2" '
    'xmlns:tns1="http://www.onvif.org/ver10/topics" '
    f'xmlns:mct="{VENDOR}">\n'
)
XML_TAIL = '</tt:MetadataStream>\n'
_TYPES = {
    int(ClassCode.PERSON): 'Human',
    int(ClassCode.VEHICLE): 'Vehicle',
    int(ClassCode.BICYCLE): 'Bicycle',
    int(ClassCode.BALL): 'Ball',
}
_CROSSED = {EventCode.CROSS_LEFT: 'Left', EventCode.CROSS_RIGHT: 'Right'}
_COUNTS = (EventCode.OCCUPANCY, EventCode.CROWDED)
_DIALECT = 'http://www.onvif.org/ver10/tev/topicExpression/ConcreteSet'
_DEGREES, _METRES = 8, 3
"""Decimals of longitudes and latitudes, 1 mm, and of positions."""


@dataclass(frozen=True, slots=True)
class Notification:
    """
    An event as ONVIF tells it.

    Attributes
    ----------
    topic : str
        Without the namespace of ONVIF.
    stamp_ns : int
        When, ns.
    source, data : mapping
        What it is about, and what is said of it.

    """

    topic: str
    stamp_ns: int
    source: Mapping[str, Any]
    data: Mapping[str, Any]


def onvif_frame(frame: Frame, geo: GeoReference | None = None) -> dict[str, Any]:
    """
    Return a frame: objects with class, position and motion, and who became who.

    Parameters
    ----------
    frame : Frame
        The tick.
    geo : GeoReference, optional
        Where the site lies; without it objects have no ``GeoLocation``.

    """
    tracks = _reported(frame.tracks)
    groups = groups_of(tracks)
    parents = {member: group for group, members in groups.items() for member in members}
    values: dict[str, Any] = {'@UtcTime': utc(frame.stamp_ns), '@Source': SOURCE}
    objects = [
        {'@ObjectId': _group_id(group), 'Appearance': {'Class': {'Type': [{'#text': 'Group'}]}}}
        for group in groups
    ]
    objects += _objects(tracks, parents, geo)
    tree = object_tree(frame)
    more = {'Object': objects, 'ObjectTree': tree}
    return values | {name: value for name, value in more.items() if value}


def notifications(frame: Frame) -> Iterator[Notification]:
    """Yield a frame's events; corrections are in its `ObjectTree`."""
    for events in frame.events:
        for row, code in enumerate(events.event.tolist()):
            if code != EventCode.CORRECTION:
                yield _notification(events, row, frame)


def object_tree(frame: Frame) -> dict[str, Any]:
    """Return what corrections and groups change since the frame before; empty: nothing."""
    tracks, shown = _reported(frame.tracks), _reported(frame.before)
    alive, groups = set(tracks.track_id.tolist()), groups_of(tracks)
    before, groups_before = set(shown.track_id.tolist()), groups_of(shown)
    renames, splits, merges = [], [], []
    for events in frame.events:
        for row, code in enumerate(events.event.tolist()):
            old, new = int(events.old_id[row]), int(events.new_id[row])
            if code == EventCode.CORRECTION and old not in alive and {old, new} <= before:
                merges.append({'from': _ids(old, new), 'to': _id(new)})
            elif code == EventCode.CORRECTION:
                renames.append({'from': _id(old), 'to': _id(new)})
            elif code == EventCode.SPLIT and old:
                splits.append({'from': _id(old), 'to': _ids(old, new)})
    for group in sorted(groups.keys() | groups_before.keys()):
        now, then = groups.get(group, []), groups_before.get(group, [])
        come = [member for member in now if member not in then]
        left = [member for member in then if member not in now and member in alive]
        itself = [_group_id(group)]
        if come and len(now) > 1:
            merges.append({'from': _ids(*(itself if then else []), *come), 'to': _id(*itself)})
        if left and (now or len(left) > 1):
            splits.append({'from': _id(*itself), 'to': _ids(*(itself if now else []), *left)})
    changes = {
        'Rename': renames,
        'Split': splits,
        'Merge': merges,
        'Delete': _ids(*frame.forgotten),
    }
    return {name: listed for name, listed in changes.items() if listed}


def xml_frame(frame: Frame, geo: GeoReference | None = None) -> str:
    """Return the elements of a frame."""
    text = f'<tt:VideoAnalytics>{_xml("Frame", onvif_frame(frame, geo))}</tt:VideoAnalytics>'
    messages = ''.join(_notification_xml(each) for each in notifications(frame))
    return text + (f'<tt:Event>{messages}</tt:Event>\n' if messages else '\n')


def json_frame(frame: Frame, geo: GeoReference | None = None) -> str:
    """Return the payload of a frame for the topic of `metadata_topic`."""
    values = {'@context': {'mct': VENDOR}} | onvif_frame(frame, geo)
    return json.dumps({'Frame': [values]}, separators=(',', ':'))


def json_event(notification: Notification) -> str:
    """Return the payload of an event for its topic."""
    return json.dumps(
        {
            'UtcTime': utc(notification.stamp_ns),
            'Source': notification.source,
            'Data': notification.data,
        }
    )


def metadata_topic(prefix: str) -> str:
    """Return the topic of frames (ONVIF Analytics Service, JSON over MQTT)."""
    return f'{prefix}/onvif-mj/VideoAnalytics/{PROFILE}/{SOURCE}'


def event_topic(prefix: str, notification: Notification) -> str:
    """Return the topic of an event (ONVIF Core Specification, event broker)."""
    values = '/'.join(
        str(value).translate({ord(sign): None for sign in '#+/'})
        for value in notification.source.values()
    )
    return f'{prefix}/onvif-ej/{notification.topic}/&{values}'


def _reported(tracks: Tracks) -> Tracks:
    return tracks.select(np.isin(tracks.status, REPORTED))


def _objects(
    tracks: Tracks, parents: Mapping[int, int], geo: GeoReference | None
) -> list[dict[str, Any]]:
    places = rounded(tracks.position, _METRES)
    covariances = tracks.covariance[:, [0, 0, 1], [0, 1, 1]].tolist()
    velocity = tracks.velocity.astype(np.float64)
    speeds = rounded(np.hypot(*velocity.T), 2)
    yaws = rounded(np.degrees(np.arctan2(velocity[:, 1], velocity[:, 0])), 1)
    degrees = rounded(geo.degrees(tracks.position[:, :2]), _DEGREES) if geo else []
    rows = zip(
        tracks.track_id.tolist(),
        tracks.class_id.tolist(),
        rounded(tracks.score, 2),
        places,
        covariances,
        speeds,
        yaws,
    )
    objects = []
    for row, (track, class_id, score, (x, y, z), covariance, speed, yaw) in enumerate(rows):
        appearance: dict[str, Any] = {}
        if class_id in _TYPES:
            kind = {'@Likelihood': score, '#text': _TYPES[class_id]}
            appearance['Class'] = {'Type': [kind]}
        if None not in (x, y, z):
            xx, xy, yy = (float(f'{value:.3g}') for value in covariance)
            position = {'@x': x, '@y': y, '@z': z, '@xx': xx, '@xy': xy, '@yy': yy}
            appearance['Extension'] = {'mct:Position': position}
            if geo:
                longitude, latitude = degrees[row]
                appearance['GeoLocation'] = {'@lon': longitude, '@lat': latitude}
        one: dict[str, Any] = {'@ObjectId': track}
        if track in parents:
            one['@Parent'] = _group_id(parents[track])
        one['Appearance'] = appearance
        one['Behaviour'] = {'Speed': speed, 'Direction': {'@yaw': yaw}}
        objects.append(one)
    return objects


def _notification(events: Events, row: int, frame: Frame) -> Notification:
    code, zone = int(events.event[row]), int(events.zone[row])
    source: dict[str, Any] = {'VideoSource': PROFILE}
    if zone:
        source['Rule'] = frame.zone_name(zone) or f'zone{zone}'
    name = ''.join(word.title() for word in event_name(code).split('_'))
    topic = 'LineDetector/Crossed' if code in _CROSSED else f'mct:Tracking/{name}'
    return Notification(f'RuleEngine/{topic}', events.stamp_ns, source, _data(events, row))


def _data(events: Events, row: int) -> dict[str, Any]:
    """Return who did what where, and how sure that is."""
    code = int(events.event[row])
    data: dict[str, Any] = {}
    if code in _COUNTS:
        data['Count'] = int(events.new_id[row])
    else:
        data['ObjectId'] = int(events.track_id[row])
    others = events.others[row][events.others[row] > 0].tolist()
    if others:
        data['Others'] = ' '.join(map(str, others))
    if np.isfinite(events.position[row]).all():
        data['x'], data['y'], _ = rounded(events.position[row], _METRES)
    data['Likelihood'] = rounded(events.probability[row], 2)
    if code in _CROSSED:
        data['Direction'] = _CROSSED[EventCode(code)]
    return data


def _notification_xml(notification: Notification) -> str:
    parts = [
        ''.join(
            f'<tt:SimpleItem Name={attribute(name)} Value={attribute(str(value))}/>'
            for name, value in values.items()
        )
        for values in (notification.source, notification.data)
    ]
    return (
        f'<wsnt:NotificationMessage><wsnt:Topic Dialect="{_DIALECT}">'
        f'tns1:{notification.topic}</wsnt:Topic><wsnt:Message>'
        f'<tt:Message UtcTime="{utc(notification.stamp_ns)}">'
        f'<tt:Source>{parts[0]}</tt:Source><tt:Data>{parts[1]}</tt:Data>'
        '</tt:Message></wsnt:Message></wsnt:NotificationMessage>'
    )


def _xml(name: str, value: Any) -> str:
    """Return a value of ONVIF's JSON as elements of a name."""
    if isinstance(value, list):
        return ''.join(_xml(name, each) for each in value)
    tag = name if ':' in name else f'tt:{name}'
    if not isinstance(value, dict):
        return f'<{tag}>{escape(str(value))}</{tag}>'
    attributes = ''.join(
        f' {key[1:]}={attribute(str(each))}' for key, each in value.items() if key[0] == '@'
    )
    inside = ''.join(
        escape(str(each)) if key == '#text' else _xml(key, each)
        for key, each in value.items()
        if key[0] != '@'
    )
    return f'<{tag}{attributes}>{inside}</{tag}>' if inside else f'<{tag}{attributes}/>'


def _group_id(group: int) -> int:
    return GROUP_IDS + group


def _id(number: int) -> dict[str, int]:
    return {'@ObjectId': number}


def _ids(*numbers: int) -> list[dict[str, int]]:
    return [_id(number) for number in numbers]
