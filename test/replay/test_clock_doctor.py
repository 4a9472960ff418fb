"""Clocks that differ in a recording: measured, told, and corrected once."""

import json

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from fusion_scenes import detections
from mctrack_ros.cli.main import app
from mctrack_ros.codec import rows_from_cloud
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import BagReader, BagWriter, stated_clock_offsets

START_NS = 1_700_000_000 * 10**9
CAMERAS = ('cam1', 'cam2', 'cam3')
AHEAD_S = 0.06


def places(seconds):
    """Return where four people are, who walk on circles."""
    number = np.arange(4)
    phase = number + 1.5 * seconds / (2.0 + number)
    return np.column_stack([np.cos(phase), np.sin(phase)]) * (2.0 + number)[:, None] + np.array(
        [[0.0, 0.0], [12.0, 0.0], [0.0, 14.0], [14.0, 14.0]]
    )


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with detections of three cameras, the second one's clock ahead."""
    folder, rng = tmp_path_factory.mktemp('clocks'), np.random.default_rng(2)
    with BagWriter(folder / 'in') as bag:
        for seconds in np.arange(0.0, 30.0, 0.1):
            true_ns = START_NS + round(seconds * 1e9)
            for camera in CAMERAS:
                shown = places(seconds) + rng.normal(0.0, 0.05, (4, 2))
                stamp_ns = true_ns + round(AHEAD_S * 1e9) * (camera == 'cam2')
                rows = detections(stamp_ns, shown, 0.1)
                bag.write_rows(f'/{camera}/detections', rows, 'map', true_ns + 10_000_000)
    return folder


def write_site(folder, **offsets):
    cameras = {camera: {'clock_offset': offsets.get(camera, 0.0)} for camera in CAMERAS}
    batching = {'period': 0.1, 'time_sync_limit': 0.0}
    content = {'cameras': cameras, 'fusion': {'batching': batching, 'tracker': 'joint'}}
    (folder / 'site.yaml').write_text(yaml.safe_dump(content))
    return str(folder / 'site.yaml')


def examined(folder, bag, **offsets):
    """Return what is found about the second camera's clock."""
    command = ['doctor', write_site(folder, **offsets), str(bag), '--clocks']
    CliRunner().invoke(app, [*command, '--json', str(folder / 'found.json')])
    findings = json.loads((folder / 'found.json').read_text())
    return next(
        one for one in findings if one['about'] == 'cam2' and 'its clock is' in one['what']
    )


def stated(finding):
    return float(finding['remedy'].rpartition('clock_offset: ')[2])


def tracked(folder, bag, out, **offsets):
    command = ['track', str(bag), '--site', write_site(folder, **offsets), '--overwrite']
    done = CliRunner().invoke(app, [*command, '--out', str(folder / out), '--processes', '1'])
    assert done.exit_code == 0, done.output
    return folder / out / 'bag'


def first_stamp_ns(bag):
    with BagReader(bag) as reader:
        _, message, _ = next(reader.messages(['/cam2/detections']))
        return rows_from_cloud(message, Detections).stamp_ns


def test_the_doctor_says_what_to_write_and_is_content_then(folder):
    finding = examined(folder, folder / 'in')
    assert finding['severity'] == 'warning'
    assert stated(finding) == pytest.approx(AHEAD_S, abs=0.01)
    finding = examined(folder, folder / 'in', cam2=stated(finding))
    assert (finding['severity'], finding['remedy']) == ('note', 'nothing is to be done')


def test_a_stated_offset_is_taken_from_the_stamps_once(folder):
    bag = tracked(folder, folder / 'in', 'first', cam2=AHEAD_S)
    assert first_stamp_ns(bag) == START_NS
    with BagReader(bag) as reader:
        assert stated_clock_offsets(reader) == {'cam2': AHEAD_S}
    assert first_stamp_ns(tracked(folder, bag, 'second', cam2=AHEAD_S)) == START_NS
    finding = examined(folder, bag, cam2=AHEAD_S)
    assert finding['severity'] == 'note'
    assert f'{AHEAD_S:.2f}'[:-1] in finding['what']
    again = examined(folder, bag)
    assert stated(again) == pytest.approx(AHEAD_S, abs=0.01)
