"""The fusion node with masks: tracks, and whose masks are left out."""

import json

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import CompressedImage, PointCloud2
from std_msgs.msg import String

from drawn_hall import SIZE, projection
from masks import AREA, MAPPINGS, POSITIONS, SHAPE, foreground_of
from mctrack_ros.codec import ros_from_message
from mctrack_ros.interfaces import Detections, Foreground, Tracks
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched

pytestmark = pytest.mark.live
PERIOD_NS = 40_000_000
PLACE = np.array([[0.3, 0.2]])


@pytest.fixture
def site(tmp_path):
    """Write a site; return its path."""
    cameras = {}
    for name, position in POSITIONS.items():
        matrix = projection(position).tolist()
        (tmp_path / f'{name}.yaml').write_text(yaml.safe_dump({'image_from_world': matrix}))
        size = dict(zip(('image_width', 'image_height'), SIZE))
        cameras[name] = {'calibration': f'{name}.yaml', **size}
    content = {'cameras': cameras, 'area': AREA, 'fusion': {'tracker': 'occupancy'}}
    path = tmp_path / 'site.yaml'
    path.write_text(yaml.safe_dump(content))
    return path


def parameters(site, **others):
    fusion = {'tracker': 'occupancy', 'batching': {'max_wait': 50.0}}
    return {'cameras': list(MAPPINGS), 'fusion': fusion, 'site': str(site)} | others


class Masks:
    """What camera nodes would publish."""

    def __init__(self, bench):
        self.bench, self.index = bench, 100
        self.tracks = bench.rows(Tracks, '/tracks')
        self.senders = [
            (
                name,
                bench.publisher(PointCloud2, f'/{name}/detections'),
                bench.publisher(CompressedImage, f'/{name}/foreground/compressed'),
            )
            for name in MAPPINGS
        ]
        bench.heard('/tracks')

    def show(self, count, **others):
        for _ in range(count):
            stamp_ns, before = self.index * PERIOD_NS, len(self.tracks)
            for name, detections, masks in self.senders:
                own = others.get(name, foreground_of(name, PLACE, stamp_ns)).at(stamp_ns)
                masks.publish(ros_from_message(own, RCLPY_CLASSES, 'map'))
                nobody = Detections.build(stamp_ns)
                detections.publish(ros_from_message(nobody, RCLPY_CLASSES, 'map'))
            self.bench.until(lambda before=before: len(self.tracks) > before)
            self.index += 1


def test_masks_become_tracks_and_who_is_left_out_is_named(bench, site):
    bench.make(FusionNode, **parameters(site))
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    sites = bench.messages(String, '/site', latched())
    graph = Masks(bench)
    graph.show(20)
    bench.until(lambda: sites)
    assert json.loads(sites[0].data)['image_sizes'] == {name: list(SIZE) for name in MAPPINGS}
    assert np.linalg.norm(graph.tracks[-1].position[:, :2] - PLACE, axis=1) < 0.3

    def states():
        found = {each.name: each for each in reports[-1].status} if reports else {}
        return {
            name: next((one for key, one in found.items() if key.endswith(f'{name} mask')), None)
            for name in MAPPINGS
        }

    white = Foreground(0, np.full(SHAPE, 255, np.uint8))
    graph.show(3, east=white, south=Foreground.build(0))
    bench.until(lambda: states()['east'] and states()['east'].level == DiagnosticStatus.WARN)
    assert 'more than 60% of its image is foreground' in states()['east'].message
    assert 'does not know its background' in states()['south'].message
    assert states()['north'].level == DiagnosticStatus.OK
    graph.show(3)
    bench.until(lambda: states()['east'].level == DiagnosticStatus.OK)


def test_a_mask_that_is_none_is_refused_and_the_node_lives_on(bench, site):
    node = bench.make(FusionNode, **parameters(site))
    graph = Masks(bench)
    graph.senders[0][2].publish(CompressedImage(format='png', data=b'nothing'))
    bench.until(lambda: node.health['east'].totals.get('refused') == 1)
    graph.show(2)


@pytest.mark.parametrize(
    ('wrong', 'reason'),
    [
        ({'site': ''}, 'name the site'),
        ({'cameras': ['east', 'west']}, 'lacks cameras: west'),
        ({'origin': '1000,0'}, 'give the same'),
    ],
)
def test_a_site_that_does_not_fit_is_refused(bench, site, wrong, reason):
    file = bench.parameter_file('fusion', parameters(site, autostart=False) | wrong)
    bench.open('--params-file', str(file))
    node = bench.add(FusionNode())
    node.trigger_configure()
    assert reason in node.failure
