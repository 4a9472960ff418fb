"""A small match with truth, and a recording of tracks with known faults."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.interfaces import Detections, Ticks, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter

PERIOD_NS = 40_000_000
OFFSET_NS = 1_700_000_000 * 10**9
CAMERAS = ('cam1', 'cam2')
PEOPLE = 4
INSTANTS = 100
SWITCH_AT = 60
AHEAD = np.array([0.5, 0.0, 0.0])
HOSTILE = '<script>alert(1)</script>'


def stamp_ns(instant):
    return instant * PERIOD_NS + PERIOD_NS // 2


def places(instant):
    lane = 10.0 + 12.0 * np.arange(PEOPLE)
    return np.column_stack([20.0 + 0.2 * instant + 0 * lane, lane, 0 * lane])


def tracks_at(instant, stamp):
    """Return tracks half a metre off; people 1 and 2 change ids, person 4 is lost at the end."""
    ids = np.array([11, 12, 13, 14])
    if instant >= SWITCH_AT:
        ids[:2] = ids[1::-1]
    kept = np.arange(PEOPLE) < (PEOPLE if instant < 90 else PEOPLE - 1)
    return Tracks.build(stamp, position=(places(instant) + AHEAD)[kept], track_id=ids[kept])


def write_source(path):
    image = np.full((120, 160, 3), 90, np.uint8)
    jpeg = jpeg_from_image(image)
    with BagWriter(path) as bag:
        for instant in range(INSTANTS):
            stamp = stamp_ns(instant)
            truth = Tracks.build(stamp, position=places(instant), track_id=[1, 2, 3, 4])
            bag.write_rows('/truth/tracks', truth, 'map')
            for camera in CAMERAS:
                message = compressed_message(jpeg, ROSBAGS_CLASSES, stamp, camera)
                bag.write(f'/{camera}/image_raw/compressed', message, stamp)


def write_recording(path):
    """Record with a latency of 20 ms; the first truth is missed, cam2 is late at 0.4 s and 3 s."""
    with BagWriter(path) as bag:
        bag.write_text('/site', json.dumps({'cameras': CAMERAS, 'name': HOSTILE}), OFFSET_NS)
        for instant in range(INSTANTS):
            stamp = stamp_ns(instant) + OFFSET_NS
            logged = stamp + 20_000_000
            if instant:
                truth = Tracks.build(stamp, position=places(instant), track_id=[1, 2, 3, 4])
                bag.write_rows('/truth/tracks', truth, 'map', stamp)
            for camera in CAMERAS:
                detections = Detections.build(
                    stamp,
                    box=[[20, 30, 10, 40], [60, 30, 30, 40]],
                    track_id=[11, 0],
                    member_count=[1, 2],
                    members=[[0] * 16, [12, 13, *[0] * 14]],
                )
                bag.write_rows(f'/{camera}/detections', detections, 'map', logged)
            late = np.array([0, int(instant in (10, 75))])
            ticks = Ticks.build(
                stamp,
                camera=[0, 1],
                admitted=1 - late,
                detections=2 * (1 - late),
                late=late,
                dropped_detections=2 * late,
                missing=late,
                alive=[1, 1],
            )
            bag.write_rows('/ticks', ticks, 'map', logged)
            bag.write_rows('/tracks', tracks_at(instant, stamp), 'map', logged)


@pytest.fixture(scope='session')
def match(tmp_path_factory):
    """Folder with the bags ``source`` and ``bag``, and what is in them."""
    folder = tmp_path_factory.mktemp('match')
    write_source(folder / 'source')
    write_recording(folder / 'bag')
    return SimpleNamespace(
        folder=folder,
        source=folder / 'source',
        recorded=folder / 'bag',
        instants=INSTANTS,
        people=PEOPLE,
        period_ns=PERIOD_NS,
        offset_ns=OFFSET_NS,
    )
