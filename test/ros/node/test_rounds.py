"""Every node goes round its lifecycle several times and leaves nothing behind."""

import gc
import os
import threading

import pytest

from mctrack_ros.cli.sites import site_path
from mctrack_ros.ros.nodes.camera_node import CameraNode
from mctrack_ros.ros.nodes.coverage_node import CoverageNode
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.nodes.player import Player
from mctrack_ros.ros.nodes.recorder import Recorder
from mctrack_ros.ros.nodes.simulator_node import SimulatorNode
from mctrack_ros.ros.nodes.store_node import StoreNode
from mctrack_ros.ros.nodes.stream_node import StreamNode
from walker import camera_parameters

pytestmark = pytest.mark.live
ROUNDS = 3


@pytest.fixture
def parameters(tmp_path, projection, walker_bag):
    """Return what each node needs, by its class."""
    return {
        CameraNode: camera_parameters(projection),
        FusionNode: {'cameras': ['cam1', 'cam2']},
        StoreNode: {'database': str(tmp_path / 'tracks.db')},
        StreamNode: {'port': 0},
        CoverageNode: {'site': str(site_path('pitch5').absolute())},
        Recorder: {'path': str(tmp_path / 'bag'), 'overwrite': True, 'min_free_mb': 0.0},
        SimulatorNode: {'cameras': ['cam1'], 'rate': 5.0},
        Player: {'path': str(walker_bag)},
    }


def left(node):
    """Return how much a node and its process hold."""
    gc.collect()
    return {
        'subscriptions': len(list(node.subscriptions)),
        'publishers': len(list(node.publishers)),
        'timers': len(list(node.timers)),
        'services': len(list(node.services)),
        'clients': len(list(node.clients)),
        'guards': len(list(node.guards)),
        'threads': threading.active_count(),
        'files': len(os.listdir('/proc/self/fd')),
    }


@pytest.mark.parametrize(
    'kind',
    [
        *(CameraNode, FusionNode, StoreNode, StreamNode),
        *(CoverageNode, Recorder, SimulatorNode, Player),
    ],
)
def test_a_node_that_goes_round_leaves_nothing_behind(bench, parameters, kind):
    node = bench.make(kind, autostart=False, **parameters[kind])
    held = []
    for _ in range(ROUNDS):
        for transition in ('configure', 'activate', 'deactivate', 'cleanup'):
            getattr(node, f'trigger_{transition}')()
            assert not node.failure, transition
            for _ in range(10):
                bench.executor.spin_once(timeout_sec=0.02)
        held.append(left(node))
    assert held[1] == held[2]
