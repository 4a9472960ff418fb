"""What the live map costs: the server's processor time, and how smoothly the page draws."""

from __future__ import annotations

import importlib
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.recording import BagWriter
from mctrack_ros.ros.graph.graph import player_node

TRACKS, RATE_HZ = 25, 10
SECONDS, WARM_UP_S = 30.0, 5.0
_DOMAIN = '101'
_PERIOD_NS = 1_000_000_000 // RATE_HZ
_LENGTH_S = 60
_CHROMIUM = ('chromium', 'chromium-browser')
_PAGE_STATE = 'window.mctrackMap && window.mctrackMap.state'


def bench_map(seconds: float = SECONDS) -> Figures:
    """
    Show a running graph's tracks to one browser.

    A player publishes them; the map runs as `mctrack map pitch5` does. Chromium runs headless,
    1440 x 900, and draws without a graphics processor.

    Parameters
    ----------
    seconds : float
        How long it is measured, after `WARM_UP_S`.

    Raises
    ------
    OSError
        If Chromium or Playwright is not installed.

    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write_bag(folder / 'bag')
        command = player_node(folder / 'bag', loop=True, restamp=True).process(folder).command
        environment = os.environ | {'ROS_DOMAIN_ID': _DOMAIN}
        with _running(command, environment), _page(environment) as (server, page):
            page.wait_for_function(f'{_PAGE_STATE}.tracks.length == {TRACKS}', timeout=60_000)
            time.sleep(WARM_UP_S)
            figures = _measured(server, page, seconds)
    return Figures(
        'bench_map',
        'mctrack bench map',
        {
            'tracks': TRACKS,
            'rate_hz': RATE_HZ,
            'seconds': seconds,
            'window': '1440 x 900, headless Chromium without a graphics processor',
            'layers': 'as when it is opened: ids, trails, groups, fields of view, zones',
            'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
        },
        figures,
    )


def _write_bag(path: Path) -> None:
    """Write people who walk in circles on the pitch, and an event a second."""
    numbers = np.arange(TRACKS)
    middle = np.column_stack([10 + numbers % 5 * 21.0, 8 + numbers // 5 * 13.0])
    began_ns = 1_700_000_000_000_000_000
    with BagWriter(path) as writer:
        for k in range(_LENGTH_S * RATE_HZ):
            angle = numbers + 2 * np.pi * k / (_LENGTH_S * RATE_HZ) * 8
            around = np.column_stack([np.cos(angle), np.sin(angle)])
            place = np.column_stack([middle + 4 * around, np.zeros(TRACKS)])
            tracks = Tracks.build(
                began_ns + k * _PERIOD_NS,
                position=place,
                velocity=around[:, ::-1] * [-3.0, 3.0],
                covariance=np.tile(0.05 * np.eye(4), (TRACKS, 1, 1)),
                track_id=numbers + 1,
                group=np.where(numbers < 2, 1, 0),
                status=np.ones(TRACKS),
            )
            writer.write_rows('/tracks', tracks, 'map')
            if k % RATE_HZ == 0:
                event = Events.build(
                    tracks.stamp_ns,
                    position=place[:1],
                    track_id=[1],
                    event=[EventCode.MERGE],
                )
                writer.write_rows('/events', event, 'map')


def _measured(server: int, page: Any, seconds: float) -> dict[str, float]:
    """Return the share of a core that the server takes, and what the page draws a second."""
    frames = page.evaluate(f'{_PAGE_STATE}.frames')
    began, used = time.perf_counter(), _processor_s(server)
    time.sleep(seconds)
    passed, used = time.perf_counter() - began, _processor_s(server) - used
    drawn = page.evaluate(f'{_PAGE_STATE}.frames') - frames
    return {'core_share': used / passed, 'frames_per_s': drawn / passed}


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        return int(free.getsockname()[1])


def _processor_s(process: int) -> float:
    """Return the processor time of a process and all its threads, s."""
    fields = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


@contextmanager
def _running(command: tuple[str, ...], environment: dict[str, str]) -> Iterator[int]:
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    try:
        yield process.pid
    finally:
        process.terminate()
        process.wait()


@contextmanager
def _page(environment: dict[str, str]) -> Iterator[tuple[int, Any]]:
    """Give the server's process and a page that shows the map."""
    chromium = next(filter(None, map(shutil.which, _CHROMIUM)), None)
    try:
        api = importlib.import_module('playwright.sync_api')
    except ImportError as error:
        raise OSError('the page is driven by Playwright: pip install playwright') from error
    if chromium is None:
        raise OSError('the page is shown by Chromium, which is not installed')
    command = [sys.executable, '-P', '-m', 'mctrack_ros.cli.main', 'map', 'pitch5']
    command += ['--no-browser', '--port', str(_free_port())]
    server = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        address = next((line.split()[0] for line in server.stdout if line[:4] == 'http'), '')
        if not address:
            raise OSError('mctrack map ended without serving a page')
        with api.sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=chromium, chromium_sandbox=os.geteuid() != 0
            )
            page = browser.new_page(viewport={'width': 1440, 'height': 900})
            page.goto(address)
            yield server.pid, page
            browser.close()
    finally:
        server.terminate()
        server.wait()
