"""Camera nodes and the fusion node with belief propagation, live."""

import numpy as np
import pytest
import yaml
from sensor_msgs.msg import CompressedImage, PointCloud2

from drawn_hall import SIZE, image, projection
from mctrack_ros.codec import cloud_from_rows, compressed_message, jpeg_from_image
from mctrack_ros.config import values_of
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Belief, Detections, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.live
PERIOD_NS = 40_000_000
POSITIONS = {'east': (13.0, 1.0, 7.0), 'north': (-1.0, -13.0, 7.0)}
MAPPINGS = {name: ProjectiveMapping(projection(at), SIZE) for name, at in POSITIONS.items()}
PLACE = np.array([[0.3, 0.2]])


@pytest.fixture
def site(tmp_path):
    """Write a site and read it."""
    cameras = {}
    for name, position in POSITIONS.items():
        matrix = projection(position).tolist()
        (tmp_path / f'{name}.yaml').write_text(yaml.safe_dump({'image_from_world': matrix}))
        size = dict(zip(('image_width', 'image_height'), SIZE))
        cameras[name] = {'calibration': f'{name}.yaml', **size}
    content = {
        'cameras': cameras,
        'pipeline': {'local_tracker': 'belief', 'background': {'learning_s': 1.0}},
        'fusion': {'tracker': 'belief', 'batching': {'max_wait': 50}},
    }
    path = tmp_path / 'site.yaml'
    path.write_text(yaml.safe_dump(content))
    return load_site(path)


def test_images_become_particles_messages_and_tracks_and_tracks_start_and_end_when_asked(
    bench, site
):
    bench.open()
    fusion = {'cameras': list(MAPPINGS), 'site': site.path, 'fusion': values_of(site.fusion)}
    bench.spawn('fusion_node', **fusion)
    for name in MAPPINGS:
        own = {'camera': name, 'settings': values_of(site.cameras[name]), 'reliable': True}
        bench.spawn('camera_node', name=f'{name}_camera', **own)
    told, back = bench.rows(Belief, '/east/belief'), bench.rows(Belief, '/belief')
    tracks = bench.rows(Tracks, '/tracks')
    senders = {
        name: bench.publisher(CompressedImage, f'/{name}/image_raw/compressed')
        for name in MAPPINGS
    }
    start = bench.publisher(PointCloud2, '/start')
    bench.until(lambda: bench.observer.count_subscribers('/belief') == 1 + len(MAPPINGS))
    rng = np.random.default_rng(3)
    indices = iter(range(100, 1000))

    def show(people):
        stamp_ns = next(indices) * PERIOD_NS
        for name, sender in senders.items():
            jpeg = jpeg_from_image(image(MAPPINGS[name], people, rng))
            sender.publish(compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, name))
        return stamp_ns

    def show_until_fused(people):
        stamp_ns = show(people)
        bench.until(lambda: tracks[-1].stamp_ns >= stamp_ns)

    bench.answer(lambda: show(np.zeros((0, 2))), tracks)
    for people in [np.zeros((0, 2))] * 31 + [PLACE] * 20:
        show_until_fused(people)
    assert tracks[-1].status.tolist() == [TrackStatus.CONFIRMED]
    assert np.linalg.norm(tracks[-1].position[:, :2] - PLACE, axis=1) < 0.5
    # A camera whose feedback is late says nothing of that image.
    assert max(len(each) for each in told[-10:]) == 200
    assert max(len(np.unique(each.view)) for each in back[-10:]) == 1 + len(MAPPINGS)

    def asked(**columns):
        rows = Detections.build(tracks[-1].stamp_ns + 1, **columns)
        start.publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))

    asked(position=[[-2.0, -1.0, 0.0]])
    while len(tracks[-1]) < 2:
        show_until_fused(PLACE)
    new = int(tracks[-1].track_id.max())
    asked(position=[[np.nan] * 3], track_id=[new])
    while new not in tracks[-1].track_id[tracks[-1].status == TrackStatus.DELETED]:
        show_until_fused(PLACE)
    show_until_fused(PLACE)
    assert len(tracks[-1]) == 1
