"""Whole paths at once give what the engine finds tick after tick."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.interfaces import EventCode, Events
from mctrack_ros.zones.engine import ZoneEngine
from mctrack_ros.zones.paths import NEVER_NS, Paths, passages, stays
from mctrack_ros.zones.shapes import Line, Zone, Zones
from zone_walks import corrections, stamp_ns, tracks

ZONE = Zone('yard', ((0.0, 0.0), (3.0, 0.0), (1.0, 1.0), (3.0, 4.0), (-1.0, 3.0)), probability=0.9)
LINE = Line('path', ((-1.0, 1.0), (1.0, 1.0), (1.5, 3.0)))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.3))
def test_the_engine_and_whole_paths_agree(seed, sigma):
    random = np.random.default_rng(seed)
    steps = random.normal(0, 0.25, (150, 3, 2))
    walk = (np.array([1.0, 1.5]) + np.cumsum(steps, axis=0)).astype(np.float32).astype(float)
    pauses = random.integers(0, 150, (3, 2))
    engine, told, rows = ZoneEngine(Zones((ZONE,), (LINE,))), [], []
    for tick, places in enumerate(walk.tolist()):
        seen = {
            life: place
            for life, place in enumerate(places, start=1)
            if not pauses[life - 1, 0] <= tick < pauses[life - 1, 1]
        }
        told.append(engine.step(tracks(tick, seen, sigma), corrections(tick)))
        rows += [(life, stamp_ns(tick), place) for life, place in seen.items()]
    life, stamp, place = (np.array(each) for each in zip(*rows))
    sigma = float(np.float32(sigma**2))
    paths = Paths(life, stamp, place, np.tile(np.eye(2) * sigma, (len(life), 1, 1)))
    ticks = np.array([stamp_ns(tick) for tick in range(len(walk))])
    assert crossed(passages(LINE, paths)) == sorted(
        of(told, EventCode.CROSS_LEFT, 1) + of(told, EventCode.CROSS_RIGHT, -1)
    )
    found = stays(ZONE, paths, ticks)
    changed = list(zip(found.entered_ns.tolist(), found.life.tolist(), [1] * len(found.life)))
    left = found.left_ns < NEVER_NS
    changed += zip(found.left_ns[left].tolist(), found.life[left].tolist(), [-1] * left.sum())
    assert sorted(changed) == sorted(
        of(told, EventCode.ENTER_ZONE, 1) + of(told, EventCode.LEAVE_ZONE, -1)
    )


def crossed(found):
    return sorted(zip(found.stamp_ns.tolist(), found.life.tolist(), found.way.tolist()))


def of(told: list[Events], code, way):
    return [
        (events.stamp_ns, track, way)
        for events in told
        for track in events.track_id[events.event == code].tolist()
    ]


def test_nobody_crosses_and_nobody_stays():
    nobody = Paths(*(np.zeros(0, np.int64),) * 2, np.zeros((0, 2)), np.zeros((0, 2, 2)))
    assert len(passages(LINE, nobody).life) == 0
    assert len(stays(ZONE, nobody, np.zeros(0, np.int64)).life) == 0
