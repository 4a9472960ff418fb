"""Bags whose stamps are wrong: what is right is tracked, and what is not is said."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from drawn_hall import write_hall
from fusion_scenes import detections
from mctrack_ros.cli.main import app
from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.interfaces import REPORTED, Ticks, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES, BagReader, BagWriter
from mctrack_ros.ros.topics.choice import are_images, is_private

START_NS = 1_700_000_000 * 10**9
CAMERAS = ('cam1', 'cam2', 'cam3')
COUNT = 120


@pytest.fixture
def track(tmp_path):
    """Return a function that tracks detections with stamps ahead by ``ahead_s(camera, index)``."""

    def run(ahead_s, *options, cameras=CAMERAS, stamps_are_zero=False):
        with BagWriter(tmp_path / 'in', overwrite=True) as bag:
            rng = np.random.default_rng(3)
            for index in range(COUNT):
                true_ns = START_NS + index * 40_000_000
                for camera in cameras:
                    stamp_ns = true_ns + round(ahead_s(camera, index) * 1e9)
                    places = [[1.0 + 0.02 * index, 2.0], [5.0, 4.0 - 0.02 * index]]
                    places += rng.normal(0.0, 0.05, (2, 2))
                    rows = detections(0 if stamps_are_zero else stamp_ns, places)
                    log_ns = true_ns + rng.integers(5, 25) * 1_000_000
                    bag.write_rows(f'/{camera}/detections', rows, 'map', int(log_ns))
        site = tmp_path / 'site.yaml'
        site.write_text(yaml.safe_dump({'cameras': {camera: {} for camera in cameras}}))
        command = ['track', str(tmp_path / 'in'), '--out', str(tmp_path / 'out')]
        command += ['--site', str(site), '--json', str(tmp_path / 'run.json'), '--processes', '1']
        return CliRunner().invoke(app, [*command, *options])

    return run


def figures(folder):
    return json.loads((folder / 'run.json').read_text())['figures']


def instants(folder):
    with BagReader(folder / 'out' / 'bag') as reader:
        return [rows_from_cloud(m, Tracks) for _, m, _ in reader.messages(['/tracks'])]


def assert_two_are_tracked_to_the_end(folder):
    tracked = instants(folder)
    ids = {int(i) for each in tracked for i in each.track_id[np.isin(each.status, REPORTED)]}
    assert len(ids) == 2
    assert tracked[-1].stamp_ns == pytest.approx(START_NS + (COUNT - 1) * 40_000_000, abs=3e7)
    assert len(tracked) == COUNT


@pytest.mark.parametrize('cameras', [CAMERAS, ('cam1', 'cam2'), ('cam1',)])
def test_one_stamp_far_ahead_costs_one_message(track, tmp_path, cameras):
    done = track(lambda name, i: 37600.0 * (name == 'cam1' and i == 60), cameras=cameras)
    assert done.exit_code == 0
    ahead_s = re.search(
        r'cam1: 1 messages are left out: their stamps lie ([.0-9]+) s', done.output
    )
    assert float(ahead_s[1]) == pytest.approx(37600.0, abs=0.03)
    tracked = instants(tmp_path)
    assert len({int(i) for e in tracked for i in e.track_id[np.isin(e.status, REPORTED)]}) == 2
    assert figures(tmp_path)['cam1.left_out'] == 1
    assert figures(tmp_path)['cam1.messages'] == COUNT - 1
    assert tracked[-1].stamp_ns < START_NS + COUNT * 40_000_000


def test_a_camera_that_is_ahead_for_a_while_is_left_out_for_that_while(track, tmp_path):
    done = track(lambda name, i: 4.4 * (name == 'cam2' and 60 <= i < 86))
    assert done.exit_code == 0
    assert 'cam2: 26 messages are left out: their stamps lie 4.4' in done.output
    assert 'ahead of the other messages; set its clock' in done.output
    assert figures(tmp_path)['cam2.messages'] == COUNT - 26
    assert_two_are_tracked_to_the_end(tmp_path)


@pytest.mark.parametrize('hours', [1.0, -1.0])
def test_a_camera_an_hour_off_is_named_and_the_others_go_on(track, tmp_path, hours):
    done = track(lambda name, _: 3600.0 * hours * (name == 'cam1'))
    assert done.exit_code == 0
    word = 'ahead of' if hours > 0 else 'behind'
    off_s = re.search(rf'stamps lie ([.0-9]+) s {word} the other messages', done.output)
    assert float(off_s[1]) == pytest.approx(3600.0, abs=0.03)
    assert figures(tmp_path)['cam2.messages'] == COUNT
    assert figures(tmp_path)['cam1.left_out'] == COUNT
    assert_two_are_tracked_to_the_end(tmp_path)


@pytest.mark.parametrize('ahead_s', [0.05, 0.15, -0.15])
def test_an_offset_within_the_limit_is_removed_and_said(track, tmp_path, ahead_s):
    done = track(lambda name, _: ahead_s * (name == 'cam3'))
    assert done.exit_code == 0
    assert figures(tmp_path)['cam3.added_s'] == pytest.approx(-ahead_s, abs=0.015)
    assert 'cam3: its clock is 0.' in done.output
    assert figures(tmp_path)['cam3.messages'] >= COUNT - 3
    with BagReader(tmp_path / 'out' / 'bag') as reader:
        ticks = [rows_from_cloud(m, Ticks) for _, m, _ in reader.messages(['/ticks'])]
    assert sum(int(tick.admitted.sum()) for tick in ticks) >= 3 * COUNT - 3


def test_stamps_that_all_begin_anew_are_tracked_on(track, tmp_path):
    done = track(lambda _, i: -100.0 * (i >= 75))
    assert done.exit_code == 0
    assert sum(figures(tmp_path)[f'{camera}.messages'] for camera in CAMERAS) >= 3 * COUNT - 9
    stamps = [each.stamp_ns for each in instants(tmp_path)]
    assert min(stamps[80:]) < START_NS - 90 * 10**9
    assert len(stamps) >= COUNT - 4


@pytest.mark.parametrize('ahead_s', [100.0, -100.0, 0.5])
@pytest.mark.parametrize('cameras', [CAMERAS, ('cam1',)])
def test_clocks_that_jump_together_are_said_once(track, tmp_path, cameras, ahead_s):
    def stepped(camera, index):
        return ahead_s * (index >= 75 + 2 * int(camera[-1]))

    done = track(stepped, cameras=cameras)
    said = re.findall(r'^warning: (.*)$', done.output, re.MULTILINE)
    assert len(said) == 1, said
    way = 'ahead' if ahead_s > 0 else 'back'
    found = re.match(
        rf"all cameras' stamps jumped {way} by ([.\d]+) s at ([.\d]+) s: keep", said[0]
    )
    assert float(found[1]) == pytest.approx(abs(ahead_s), abs=0.02)
    assert float(found[2]) == pytest.approx(START_NS * 1e-9 + 77 * 0.04, abs=0.03)
    assert 2 <= sum(figures(tmp_path)[f'{camera}.left_out'] for camera in cameras) <= 20
    site = (str(tmp_path / 'site.yaml'), str(tmp_path / 'in'))
    found = CliRunner().invoke(app, ['doctor', *site]).output
    assert found.count('stamps jumped') == 1
    assert 'left out' not in found


def test_two_of_three_clocks_that_jump_are_said_each(track):
    done = track(lambda name, i: 100.0 * (name != 'cam3' and i >= 75))
    assert "all cameras'" not in done.output
    assert 'messages are left out' in done.output


def test_stamps_that_are_all_zero_are_an_error_that_offers_the_log_times(track, tmp_path):
    done = track(lambda *_: 0.0, stamps_are_zero=True)
    assert 'all stamps on /cam1/detections are zero' in str(done.exception)
    assert '--log-times' in str(done.exception)
    assert track(lambda *_: 0.0, '--log-times', stamps_are_zero=True).exit_code == 0
    ids = {int(i) for e in instants(tmp_path) for i in e.track_id[np.isin(e.status, REPORTED)]}
    assert len(ids) == 2


def test_log_times_that_tell_nothing_of_arrival_leave_nobody_out(tmp_path):
    with BagWriter(tmp_path / 'in') as bag:
        for index in range(50):
            for number, camera in enumerate(CAMERAS):
                rows = detections(START_NS + index * 40_000_000, [[1.0, 2.0]])
                bag.write_rows(f'/{camera}/detections', rows, 'map', 3 * index + number)
    site = tmp_path / 'site.yaml'
    site.write_text(yaml.safe_dump({'cameras': {camera: {} for camera in CAMERAS}}))
    command = ['track', str(tmp_path / 'in'), '--out', str(tmp_path / 'out'), '--site', str(site)]
    done = CliRunner().invoke(app, [*command, '--json', str(tmp_path / 'run.json')])
    assert done.exit_code == 0
    assert [figures(tmp_path)[f'{camera}.messages'] for camera in CAMERAS] == [50] * 3


def test_a_garbled_message_costs_itself_alone_and_is_said(tmp_path):
    with BagWriter(tmp_path / 'in') as bag:
        for index in range(50):
            stamp_ns = START_NS + index * 40_000_000
            for camera in CAMERAS:
                cloud = cloud_from_rows(detections(stamp_ns, [[1.0, 2.0]]), ROSBAGS_CLASSES, 'map')
                if (camera, index) == ('cam2', 20):
                    cloud.data = cloud.data[:-8]
                bag.write(f'/{camera}/detections', cloud, stamp_ns)
    site = tmp_path / 'site.yaml'
    site.write_text(yaml.safe_dump({'cameras': {camera: {} for camera in CAMERAS}}))
    command = ['track', str(tmp_path / 'in'), '--out', str(tmp_path / 'out'), '--site', str(site)]
    done = CliRunner().invoke(app, [*command, '--json', str(tmp_path / 'run.json')])
    assert done.exit_code == 0
    assert [figures(tmp_path)[f'{camera}.messages'] for camera in CAMERAS] == [50, 49, 50]
    assert figures(tmp_path)['cam2.refused'] == 1
    assert 'cam2: 1 messages are refused, the last since a cloud of 1 Detections' in done.output


def test_debug_images_show_what_each_camera_sees(tmp_path):
    from mctrack_ros.replay.camera_source import Debug
    from mctrack_ros.replay.track import track_bag

    bag, site = write_hall(tmp_path / 'hall')
    summary = track_bag(
        bag, tmp_path / 'out', site, processes=1, debug=Debug(tmp_path / 'seen', 1.0)
    )
    for camera in site.camera_names:
        images = sorted((tmp_path / 'seen' / camera).iterdir())
        assert len(images) == 8
        settings = site.cameras[camera]
        shown = cv2.imread(str(images[-1])).astype(int)
        assert shown.shape == (settings.image_height, settings.image_width, 3)
        assert (np.abs(shown[..., 0] - shown[..., 1]) > 60).any()
    assert not [line for line in summary.notes if 'left out' in line]
    with BagReader(tmp_path / 'out' / 'bag') as reader:
        assert reader.count('/north/foreground/compressed')


def test_of_a_private_site_no_picture_is_written(tmp_path):
    bag, site = write_hall(tmp_path / 'hall')
    content = yaml.safe_load(Path(site.path).read_text()) | {'private': True}
    Path(site.path).write_text(yaml.safe_dump(content))
    command = ['track', str(bag), '--out', str(tmp_path / 'out'), '--site', site.path]
    command += ['--processes', '1']
    refused = CliRunner().invoke(app, [*command, '--debug-images', str(tmp_path / 'seen')])
    assert 'hall is private: no debug images are written' in str(refused.exception)
    assert not (tmp_path / 'out').exists()
    assert CliRunner().invoke(app, command).exit_code == 0
    assert not (tmp_path / 'seen').exists()
    with BagReader(tmp_path / 'out' / 'bag') as reader:
        assert not [kind for kind in reader.topics.values() if are_images([kind])]
        assert is_private(next(reader.messages(['/site']))[1].data)
