"""The documented node of an own detector, run as it stands."""

import subprocess
import sys

import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage

from conftest import ROOT
from mctrack_ros.codec import stamp_ns_of
from mctrack_ros.interfaces import Detections, Tracks
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from walker import EMPTY_IMAGES, PERIOD_NS, SIZE, walker_message

PATIENCE_S = 120.0
FIRST_NS = 1_700_000_000 * 10**9 + PERIOD_NS // 2


def sent(bench, publisher, image, found):
    """Publish an image, again if it is lost, as with best effort it may be."""
    stamp_ns = stamp_ns_of(image)
    for _ in range(100):
        publisher.publish(image)
        for _ in range(50):
            bench.executor.spin_once(timeout_sec=0.02)
            if found and found[-1].stamp_ns == stamp_ns:
                return
    raise AssertionError(f'no detections of the image at {stamp_ns} ns')


def test_boxes_of_an_own_detector_are_published_and_tracked(bench, projection, tmp_path):
    (tmp_path / 'hall.yaml').write_text(
        f'cameras: {{cam1: {{calibration: {projection.name}, image_width: {SIZE[0]}, '
        f'image_height: {SIZE[1]}}}}}\n'
    )
    bench.make(FusionNode, cameras=['cam1'])
    command = [
        sys.executable,
        ROOT / 'docs' / 'examples' / 'detector_node.py',
        tmp_path / 'hall.yaml',
        'cam1',
    ]
    with open(tmp_path / 'detector.log', 'w') as log:
        bench.processes.append(subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log))
    found, tracks = bench.rows(Detections, '/cam1/detections'), bench.rows(Tracks, '/tracks')
    bench.until(lambda: bench.observer.count_subscribers('/cam1/image_raw/compressed'), PATIENCE_S)
    publisher = bench.publisher(CompressedImage, '/cam1/image_raw/compressed')
    for index in range(EMPTY_IMAGES - 2, EMPTY_IMAGES + 40):
        image = walker_message(index, FIRST_NS + index * PERIOD_NS)
        sent(bench, publisher, image, found)
    by_time = {rows.stamp_ns: rows for rows in found}
    assert [len(rows) for rows in by_time.values()] == [0, 0] + [1] * 40
    for index, rows in enumerate(list(by_time.values())[2:]):
        np.testing.assert_allclose(rows.position[0, :2], [-2.0 + 0.06 * index, 0.0], atol=0.3)
        assert rows.score[0] == np.float32(0.9)
    bench.until(lambda: any(len(rows) for rows in tracks))
    assert bench.processes[0].poll() is None, (tmp_path / 'detector.log').read_text()


def test_positions_with_scores_alone_are_tracked_and_tracks_are_heard(bench, tmp_path):
    bench.make(FusionNode, cameras=['north'])
    tracks = bench.rows(Tracks, '/tracks')
    command = [sys.executable, ROOT / 'docs' / 'examples' / 'position_node.py', 'north']
    path = tmp_path / 'sensor.log'
    with path.open('w') as log:
        bench.processes.append(subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log))
    bench.until(lambda: ' is at ' in path.read_text(), PATIENCE_S)
    bench.until(lambda: any(len(rows) for rows in tracks))
    rows = next(each for each in reversed(tracks) if len(each))
    assert np.hypot(*rows.position[0, :2]) == pytest.approx(3.0, abs=0.5)
    assert f'{rows.track_id[0]} is at ' in path.read_text()
