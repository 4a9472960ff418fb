"""Two cells and the fusion of them, live: three fusion nodes, each a process."""

import subprocess
import sys

import pytest
import yaml
from sensor_msgs.msg import PointCloud2

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import EventCode, Events, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

pytestmark = pytest.mark.live

CELLS = {'north': -1.0, 'south': 1.0}
"""Which side of the border each is on; both see 1.5 m beyond it."""
STEP_M = 0.06


def start_cell(bench, cell, life=1):
    name = f'{cell}_fusion'
    bench.spawn(
        'fusion_node', '-r', f'__ns:=/{cell}', name=f'{name}{life}',
        cameras=['cam1', 'cam2'], state_file=str(bench.folder / f'{name}_ids'),
    )  # fmt: skip
    return bench.processes[-1]


def test_a_person_keeps_an_id_from_cell_to_cell_and_when_a_cell_comes_back(
    bench, tmp_path, monkeypatch
):
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'ros_home'))
    bench.open()
    first = {cell: start_cell(bench, cell) for cell in CELLS}
    zone = {'all': {'corners': [[-9, -9], [9, -9], [9, 9], [-9, 9]]}}
    site = tmp_path / 'halls.yaml'
    site.write_text(yaml.safe_dump({'cells': list(CELLS), 'zones': zone}))
    command = [sys.executable, '-m', 'mctrack_ros.cli.main', 'run', str(site)]
    bench.processes.append(subprocess.Popen(command))
    entered = bench.rows(Events, '/events')
    tracks = bench.rows(Tracks, '/tracks')
    senders = {
        (cell, camera): bench.publisher(PointCloud2, f'/{cell}/{camera}/detections')
        for cell in CELLS
        for camera in ('cam1', 'cam2')
    }
    for cell in CELLS:
        for topic in ('tracks', 'feedback'):
            bench.until(lambda topic=f'/{cell}/{topic}': bench.observer.count_publishers(topic))
            bench.until(lambda topic=f'/{cell}/{topic}': bench.observer.count_subscribers(topic))
    now = {'tick': 1000}

    def show(x):
        """Let all cameras tell of an instant with a walker at x, m; return its stamp."""
        now['tick'] += 1
        stamp_ns = now['tick'] * PERIOD_NS
        for (cell, _), sender in senders.items():
            place = [(x, 0.0)] if x * CELLS[cell] > -1.5 else []
            rows = detections(stamp_ns, place)
            sender.publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))
        return stamp_ns

    def walk(start, end):
        """Let the walker go; return id, cells and state at each instant."""
        seen = []
        for step in range(round(abs(end - start) / STEP_M)):
            stamp_ns = show(start + step * STEP_M * (1 if end > start else -1))
            bench.until(lambda stamp_ns=stamp_ns: tracks[-1].stamp_ns >= stamp_ns)
            rows = tracks[-1].select(tracks[-1].status != TrackStatus.DELETED)
            seen += list(zip(rows.track_id.tolist(), rows.cameras.tolist()))
        return seen

    bench.answer(lambda: show(-6.0), tracks)
    crossed = walk(-6.0, 4.0)
    assert {name for name, _ in crossed} == {1}
    bits = [cells for _, cells in crossed if cells]
    assert sorted(set(bits)) == [1, 2, 3]
    assert bits[0] == 1
    assert bits[-1] == 2
    first['south'].kill()
    first['south'].wait()
    bench.until(lambda: bench.observer.count_publishers('/south/tracks') == 0)
    start_cell(bench, 'south', life=2)
    bench.until(lambda: bench.observer.count_publishers('/south/tracks') == 1)
    for camera in ('cam1', 'cam2'):
        sender = senders['south', camera]
        bench.until(lambda sender=sender: sender.get_subscription_count() == 1)
    south = bench.rows(Tracks, '/south/tracks')
    bench.until(lambda: bench.observer.count_subscribers('/south/tracks') == 2)
    bench.answer(lambda: show(4.0), south)
    back = walk(4.0, -4.0)
    assert {name for name, _ in back} == {1}
    assert south[-1].stamp_ns > 0
    assert any((rows.event == EventCode.ENTER_ZONE).any() for rows in entered)
    assert all(name > 1 for rows in south for name in rows.track_id.tolist())
