"""Clouds of a running graph, for `mctrack echo`."""

import pytest

from mctrack_ros.ros.node import silence
from mctrack_ros.ros.topics import subscribe

pytestmark = pytest.mark.live


def test_who_listens_in_vain_is_told_for_what(bench, monkeypatch, capfd):
    said = []

    def spin_until_told(node):
        spin(node, timeout_sec=0.1)
        said.extend(line for line in capfd.readouterr().err.splitlines() if 'waiting' in line)
        if said:
            raise KeyboardInterrupt

    spin = subscribe.rclpy.spin_once
    monkeypatch.setattr(silence, 'PATIENCE_S', 0.1)
    monkeypatch.setattr(subscribe.rclpy, 'spin_once', spin_until_told)
    assert list(subscribe.clouds('trakcs')) == []
    assert 'waiting for /trakcs: nothing has come, nobody publishes it' in said[0]
