import json

import pytest

from mctrack_ros.web.live.requests import (
    MOST_CAMERAS,
    MOST_SIGNS,
    At,
    Draw,
    RequestError,
    Show,
    request_from,
)
from mctrack_ros.zones.shapes import MOST, MOST_POINTS

ZONE = {'kind': 'zone', 'name': 'door', 'points': [[0, 0], [1.2345, 0], [0, 1]], 'dwell_s': 3}


def asked(**content):
    return request_from(json.dumps(content))


def test_requests_are_read():
    assert asked(kind='at', time=5) == At(5.0)
    cameras = asked(kind='show', cameras=[f'cam{k}' for k in range(20)])
    assert isinstance(cameras, Show)
    assert len(cameras.cameras) == MOST_CAMERAS
    drawn = asked(kind='draw', shapes=[ZONE, {**ZONE, 'kind': 'line', 'name': 'gate'}])
    assert isinstance(drawn, Draw)
    (zone,), (line,) = drawn.zones.zones, drawn.zones.lines
    assert zone.corners == line.points == ((0.0, 0.0), (1.23, 0.0), (0.0, 1.0))
    assert zone.dwell_s == 3.0


@pytest.mark.parametrize(
    'text',
    [
        'no JSON',
        '[]',
        '{"kind": "delete all"}',
        '{"kind": "at", "time": NaN}',
        '{"kind": "at", "time": 1e300}',
        '{"kind": "find", "track": -1, "before": 0}',
        '{"kind": "draw", "shapes": [{"kind": "zone", "name": "a"}]}',
        '{"kind": "draw", "shapes": 5}',
        json.dumps({'kind': 'draw', 'shapes': [ZONE] * (MOST + 1)}),
        json.dumps({'kind': 'draw', 'shapes': [{**ZONE, 'points': [[0, 0]] * (MOST_POINTS + 1)}]}),
        '{"kind": "live", "x": "' + 'x' * MOST_SIGNS + '"}',
        '[' * 50_000,
    ],
    ids=lambda text: text[:40],
)
def test_what_is_no_request_is_refused(text):
    with pytest.raises(RequestError):
        request_from(text)
