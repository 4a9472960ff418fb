"""
From two video files to tracks in metres, as docs/tutorials/own_cameras.md tells a person to.

Its commands and its site are taken from there, word for word; only the points are others. The
machine's time is measured, the person's is counted: so many seconds for each click, command
and line typed. Measuring points on the ground is before the clock starts.
"""

import dataclasses
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.simulation import CameraRenderer, Scenario, World, true_tracks
from web.desk import PATIENCE_MS, Desk

CLICK_S, COMMAND_S, LINE_S = 4.0, 20.0, 8.0
LIMIT_S = 600.0
GATE_M = 1.0
START_S = 3.0
WORLD = World.simulated(Scenario(seed=11, duration_s=7.0, width=1280, height=720))
CAMERAS = {'north': 1, 'south': 0}
"""By the name that the person gives: which camera of the simulated pitch it is."""
COLUMNS, ROWS = (8.0, 16.0, 24.0, 32.0), (18.0, 34.0, 50.0)
POINTS = {f'{"ABC"[j]}{i + 1}': (x, y) for j, y in enumerate(ROWS) for i, x in enumerate(COLUMNS)}

PAGE = (Path(__file__).resolve().parents[2] / 'docs/tutorials/own_cameras.md').read_text()

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group('browser')]


def told(start):
    """Return the arguments of the page's first command that starts so."""
    line = next(line for line in PAGE.splitlines() if line.startswith(f'mctrack {start}'))
    return shlex.split(line)[1:]


class Person:
    """Types files and commands, and keeps the account of both."""

    def __init__(self, folder):
        self.folder = folder
        self.lines = self.commands = self.clicks = 0

    def write(self, name, *lines):
        (self.folder / name).write_text('\n'.join(lines) + '\n')
        self.lines += len(lines)

    def run(self, start):
        """Run a command of the page to its end."""
        self.commands += 1
        done = subprocess.run(
            [sys.executable, '-m', 'mctrack_ros.cli.main', *told(start)],
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=200,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    @property
    def seconds(self):
        return CLICK_S * self.clicks + COMMAND_S * self.commands + LINE_S * self.lines


@pytest.fixture
def person(tmp_path):
    """Return a person with two video files and a dozen points measured."""
    for name, index in CAMERAS.items():
        renderer = CameraRenderer(WORLD, index)
        fourcc = cv2.VideoWriter.fourcc(*'mp4v')
        size = WORLD.cameras[index].size
        video = cv2.VideoWriter(str(tmp_path / f'{name}.mp4'), fourcc, 25.0, size)
        for step in range(WORLD.scenario.steps):
            video.write(renderer.frame(step)[0])
        video.release()
    return Person(tmp_path)


def calibrated(person, browser, serve, name):
    """Click the points of one camera and save them."""
    seen = WORLD.cameras[CAMERAS[name]].project([(x, y, 0.0) for x, y in POINTS.values()])
    with serve(person.folder, *told(f'calibrate {name}.mp4')) as address:
        page = browser.new_page(viewport={'width': 1440, 'height': 860})
        page.set_default_timeout(PATIENCE_MS)
        page.goto(address)
        page.wait_for_selector('.mark')
        desk = Desk(page, POINTS, dict(zip(POINTS, seen.tolist())))
        for point in POINTS:
            desk.pair(point)
        desk.says('12 points')
        desk.save(f'{name}.xml')
        page.close()
    person.clicks += desk.clicks + 1  # Ctrl-C in the terminal
    person.commands += 1


def scores(folder):
    """Compare with everybody whom a camera sees, once the background is known."""
    scenario = WORLD.scenario
    period_ns = round(scenario.period_s * 1e9)
    with BagReader(folder / 'out/tracked/bag') as bag:
        found = [rows for rows, _ in bag.rows('/tracks', Tracks)]
    true = [true_tracks(WORLD, step) for step in range(scenario.steps)]
    tracks, truth = (
        Trajectories.from_tracks(instants, period_ns, scenario.start_ns)
        for instants in (found, true)
    )
    feet = np.column_stack([truth.position, np.zeros(len(truth))])
    seen = np.any([WORLD.cameras[index].sees(feet) for index in CAMERAS.values()], axis=0)
    truth = dataclasses.replace(truth, ignore=~seen)
    late = [rows.select(rows.frame * scenario.period_s > START_S) for rows in (truth, tracks)]
    return evaluate_ground(*late, GATE_M)


def test_two_videos_become_calibrated_tracks_in_less_than_ten_minutes(person, browser, serve):
    began = time.monotonic()
    points = [f'  <point name="{n}" x="{x}" y="{y}"/>' for n, (x, y) in POINTS.items()]
    header = '<?xml version="1.0" encoding="utf-8"?>'
    person.write('scene.xml', header, '<scene>', *points, '</scene>')
    for name in CAMERAS:
        calibrated(person, browser, serve, name)
    site = re.search('`hall.yaml`:\n\n```yaml\n(.*?)\n```', PAGE, re.DOTALL)[1]
    person.write('hall.yaml', *site.splitlines())
    person.run('track')
    machine_s = time.monotonic() - began

    found = scores(person.folder)
    print(
        f'\nmachine {machine_s:.0f} s; person {person.seconds:.0f} s: {person.clicks} clicks x '
        f'{CLICK_S:g} s, {person.commands} commands x {COMMAND_S:g} s, {person.lines} lines x '
        f'{LINE_S:g} s; together {(machine_s + person.seconds) / 60:.1f} minutes\n'
        f'{found.truth_ids} people: precision {found.precision:.3f}, recall {found.recall:.3f} '
        f'at {GATE_M:g} m, mean distance {found.mean_distance:.2f} m'
    )
    assert machine_s + person.seconds < LIMIT_S
    assert found.precision > 0.9
    assert found.recall > 0.8
    assert found.mean_distance < 0.5
