"""Two sites on one machine: in namespaces of their own, they share nothing."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2

from drawn_hall import write_hall
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

pytestmark = pytest.mark.live

PEOPLE = {'ground_floor': [[1.0, 2.0]], 'first_floor': [[-2.0, 1.0], [3.0, -1.0]]}
CAMERAS = ('north', 'south')


def test_two_sites_track_their_own_people_and_end_by_themselves(bench, tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'ros_home'))
    write_hall(tmp_path, seconds=0.1)
    bench.open()
    command = [sys.executable, '-m', 'mctrack_ros.cli.main', 'run', str(tmp_path / 'site.yaml')]
    command += ['--own-detections', '--namespace']
    graphs = {site: subprocess.Popen([*command, site]) for site in PEOPLE}
    bench.processes += graphs.values()
    tracks = {site: bench.rows(Tracks, f'/{site}/tracks') for site in PEOPLE}
    topics = {
        (site, camera): f'/{site}/{camera}/detections' for site in PEOPLE for camera in CAMERAS
    }
    publishers = {
        key: bench.publisher(PointCloud2, topic, reliable(10)) for key, topic in topics.items()
    }

    def places(site):
        """Return where the confirmed tracks of the last message of a site are, (n, 2) m."""
        if not tracks[site]:
            return np.zeros((0, 2))
        last = tracks[site][-1]
        return last.position[last.status == TrackStatus.CONFIRMED, :2]

    def all_are_tracked(sites):
        """Send detections of all sites; tell whether everybody of some has a track."""
        stamp_ns = time.time_ns()
        for (site, _), publisher in publishers.items():
            people = np.pad(PEOPLE[site], ((0, 0), (0, 1)))
            covariance = np.tile(0.01 * np.eye(2), (len(people), 1, 1))
            score = np.ones(len(people))
            rows = Detections.build(stamp_ns, position=people, covariance=covariance, score=score)
            publisher.publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))
        time.sleep(0.04)
        return all(len(places(site)) == len(PEOPLE[site]) for site in sites)

    bench.until(lambda: all_are_tracked(PEOPLE))
    for site, people in PEOPLE.items():
        apart = np.linalg.norm(places(site)[:, None] - np.array(people), axis=2)
        assert apart.min(axis=0).max() < 0.2
    graphs['ground_floor'].send_signal(signal.SIGINT)
    assert bench.exit_code(graphs['ground_floor']) == 0
    tracks['first_floor'].clear()
    bench.until(lambda: all_are_tracked(['first_floor']))
