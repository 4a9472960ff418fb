"""EPFL's terrace: the truth, the frame of the tracks, and the scores beside their protocol's."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest

from mctrack_experiments.datasets.epfl_terrace import (
    CAMERAS,
    FOLDER,
    PERIOD_NS,
    SIZE,
    image_files,
    metres_from_top_view,
    read_identities,
    read_positions,
    top_view_from_image,
)
from mctrack_experiments.real.terrace.four_cameras import (
    read_tracks,
    scored,
    write_images,
    write_site,
)
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.interfaces import Tracks, TrackStatus
from mctrack_ros.recording import BagReader, TrackTableWriter

pytestmark = pytest.mark.real_data

OURS = {
    'gate_half_metre.moda': 'moda@0.5', 'gate_half_metre.modp': 'modp@0.5',
    'gate_half_metre.precision': 'precision@0.5', 'gate_half_metre.recall': 'recall@0.5',
    'moda': 'moda@1.0', 'modp': 'modp@1.0', 'precision': 'precision@1.0', 'recall': 'recall@1.0',
    'mota': 'mota', 'idf1': 'idf1', 'switches': 'num_switches',
    'false_positives': 'num_false_positives', 'misses': 'num_misses',
}  # fmt: skip
"""Our names of the figures that the protocol of the data prints."""


@pytest.fixture(scope='module')
def wandering(data_root):
    """Return tracks of everybody, inexact, some of them lost, exchanged or not there."""
    rng, truth = np.random.default_rng(3), read_identities(data_root)
    ids = np.where(rng.random(len(truth)) < 0.01, rng.integers(0, 12, len(truth)), truth.id)
    ids += 100 * (truth.frame // 700)
    place = truth.position + rng.normal(0, 0.45, (len(truth), 2))
    kept = rng.random(len(truth)) < 0.85
    _, first = np.unique(np.column_stack([truth.frame, ids])[kept], axis=0, return_index=True)
    return Trajectories(truth.frame[kept][first], ids[kept][first], place[kept][first])


@pytest.fixture(scope='module')
def table(wandering, tmp_path_factory):
    """Return the same tracks as a file of the protocol's."""
    path = tmp_path_factory.mktemp('terrace') / 'tracks.csv'
    with path.open('w', newline='') as file:
        rows = csv.writer(file)
        rows.writerow(['frame', 'id', 'x', 'y'])
        places = zip(wandering.frame, wandering.id, wandering.position)
        rows.writerows([frame, number, *place.tolist()] for frame, number, place in places)
    return path


@pytest.mark.parametrize(
    ('cameras', 'first', 'last', 'every'),
    [
        ('0,1,2,3', 1251, 2500, False),
        ('2', 75, 1250, False),
        ('0,1', 900, 1500, True),
    ],
)
def test_scores_are_those_of_the_data_s_protocol(
    data_root, wandering, table, cameras, first, last, every
):
    options = ['--cameras', cameras, '--frames', f'{first}-{last}', *['--every'] * every]
    script = data_root / FOLDER / 'score.py'
    done = subprocess.run(
        [sys.executable, script, table, *options], capture_output=True, text=True, check=True
    )
    printed = json.loads(done.stdout)
    frames = range(first, last + 1) if every else image_files(data_root, 'c0')
    found = scored(
        wandering,
        read_positions(data_root),
        read_identities(data_root, [f'c{number}' for number in cameras.split(',')]),
        [frame for frame in frames if first <= frame <= last],
    )
    assert {name: round(value, 4) for name, value in found.items()} == {
        ours: printed[theirs] for ours, theirs in OURS.items()
    }
    assert 0.3 < found['moda'] < 0.95


def test_calibrations_agree_with_the_homographies_of_the_truth(data_root, tmp_path):
    site = write_site(data_root, tmp_path)
    truth = read_positions(data_root)
    for camera in CAMERAS:
        pixel = site.cameras[camera].mapping().image_from_ground(truth.position)
        pixel = pixel[((pixel >= 0) & (pixel < SIZE)).all(axis=1)]
        x, y, scale = (
            top_view_from_image(data_root, camera)
            @ np.pad(pixel, ((0, 0), (0, 1)), constant_values=1).T
        )
        found = metres_from_top_view(np.column_stack([x, y]) / scale[:, None])
        again = site.cameras[camera].mapping().ground_from_image(pixel)
        assert len(pixel) > 500
        assert np.median(np.linalg.norm(found - again, axis=1)) < 0.1


def test_a_track_has_the_number_of_the_image_it_comes_of(data_root, tmp_path):
    write_images(data_root, tmp_path / 'bag')
    files = image_files(data_root, 'c2')
    with (
        BagReader(tmp_path / 'bag') as bag,
        TrackTableWriter(tmp_path / 'tracks.csv', PERIOD_NS) as tracks,
    ):
        messages = bag.messages(['/c2/image_raw/compressed'])
        for (_, message, stamp_ns), file in zip(messages, files.values(), strict=True):
            assert bytes(message.data) == file.read_bytes()
            status = [TrackStatus.CONFIRMED]
            tracks.write(Tracks.build(stamp_ns, position=np.zeros((1, 3)), status=status))
    assert read_tracks(tmp_path, 0).frame.tolist() == list(files)


def test_a_later_run_begins_later_and_its_messages_arrive_in_another_order(data_root, tmp_path):
    arrived = {}
    for run in (0, 3):
        write_images(data_root, tmp_path / f'bag{run}', run)
        with BagReader(tmp_path / f'bag{run}') as bag:
            topics = [f'/{camera}/image_raw/compressed' for camera in CAMERAS]
            arrived[run] = [(stamp_ns, topic) for topic, _, stamp_ns in bag.messages(topics)]
    assert set(arrived[3]) == set(arrived[0][3 * len(CAMERAS) :])
    assert arrived[0] == sorted(arrived[0])
    assert arrived[3] != sorted(arrived[3])
