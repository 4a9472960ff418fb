"""The map beside another command runs from when somebody asks for it."""

import os
import time
from urllib.error import URLError
from urllib.request import urlopen

from mctrack_ros.cli.lazy_map import LazyMap

PATIENCE_S = 90.0


def asked(address):
    with urlopen(address, timeout=5) as answer:
        return answer.read().decode()


def until_it_says(address, text):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        try:
            if text in asked(address):
                return True
        except (URLError, ConnectionError):
            pass  # between the two servers
        time.sleep(0.2)
    return False


def test_nothing_runs_until_somebody_looks(monkeypatch, tmp_path):
    for name in [each for each in os.environ if 'PYTEST' in each]:
        monkeypatch.delenv(name)  # the page would take itself for a test
    with LazyMap([], tmp_path / 'map.log') as lazy:
        assert lazy.process is None
        assert 'The map starts' in asked(lazy.address)
        assert until_it_says(lazy.address, 'Map of tracks')
        process = lazy.process
        assert process.poll() is None
    assert process.poll() is not None
    assert not lazy.has_failed


def test_it_ends_though_nobody_looked(tmp_path):
    with LazyMap([], tmp_path / 'map.log') as lazy:
        pass
    assert lazy.process is None
    assert not lazy.has_failed


def test_a_map_that_cannot_be_shown_says_why(tmp_path):
    log = tmp_path / 'map.log'
    with LazyMap(['no_such_site'], log) as lazy:
        asked(lazy.address)
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end and (lazy.process is None or lazy.process.poll() is None):
            time.sleep(0.1)
    assert lazy.has_failed
    assert 'no_such_site' in log.read_text()
