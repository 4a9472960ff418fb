from dataclasses import replace
from pathlib import Path

import pytest

from mctrack_experiments.postgres_server import missing, postgres_server
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import load_site
from mctrack_ros.store import Database
from mctrack_ros.zones.shapes import Line, Zone, Zones

BAGS = Path(__file__).resolve().parents[2] / 'bags'


@pytest.fixture(scope='session')
def server():
    if lacking := missing():
        pytest.skip(f'no PostgreSQL with PostGIS: {lacking}')
    with postgres_server('fsync=off') as running:
        yield running


@pytest.fixture(params=['sqlite', 'postgresql'])
def place(request, tmp_path):
    """Return where a new database may be made."""
    if request.param == 'sqlite':
        return str(tmp_path / 'tracks.db')
    return request.getfixturevalue('server').new_database()


@pytest.fixture
def database(place):
    with Database(place, create=True) as opened:
        yield opened


@pytest.fixture(scope='session')
def tracked(tmp_path_factory):
    """Return the bag of six seconds of five cameras' detections, tracked."""
    out = tmp_path_factory.mktemp('tracked')
    site = load_site(BAGS / 'sites' / 'pitch5_detections' / 'default.yaml')
    half = Zone('right half', ((52.5, 0.0), (105.0, 0.0), (105.0, 68.0), (52.5, 68.0)))
    halfway = Line('halfway', ((52.5, 0.0), (52.5, 68.0)))
    site = replace(site, zones=Zones((half,), (halfway,)))
    track_bag(BAGS / 'pitch5_detections', out, site, processes=1)
    return out / 'bag'
