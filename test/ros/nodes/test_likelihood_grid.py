"""A camera node and the fusion node with likelihoods on a grid, live."""

import numpy as np
import pytest
import yaml
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import CompressedImage

from drawn_hall import SIZE, image, projection
from masks import AREA, MAPPINGS, POSITIONS
from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.config import values_of
from mctrack_ros.interfaces import Likelihood, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.occupancy import likelihood_grid
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.live
PERIOD_NS = 40_000_000
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
        'area': AREA,
        'pipeline': {'local_tracker': 'likelihood_grid', 'grid': {'person_width': 0.6}},
        'fusion': {
            'tracker': 'likelihood_grid',
            'person_width': 0.7,
            'batching': {'max_wait': 50},
        },
    }
    path = tmp_path / 'site.yaml'
    path.write_text(yaml.safe_dump(content))
    return load_site(path)


def test_images_become_likelihoods_maps_and_tracks(bench, site):
    bench.open()
    fusion = {'cameras': list(MAPPINGS), 'site': site.path, 'fusion': values_of(site.fusion)}
    bench.spawn('fusion_node', **fusion)
    for name in MAPPINGS:
        own = {'camera': name, 'settings': values_of(site.cameras[name]), 'reliable': True}
        bench.spawn('camera_node', name=f'{name}_camera', **own)
    maps = bench.messages(OccupancyGrid, '/east/likelihood_grid')
    told = bench.rows(Likelihood, '/east/likelihood')
    tracks = bench.rows(Tracks, '/tracks')
    senders = {
        name: bench.publisher(CompressedImage, f'/{name}/image_raw/compressed')
        for name in MAPPINGS
    }
    bench.until(lambda: all(sender.get_subscription_count() for sender in senders.values()))
    rng = np.random.default_rng(3)
    indices = iter(range(100, 1000))

    def show(people):
        stamp_ns = next(indices) * PERIOD_NS
        for name, sender in senders.items():
            jpeg = jpeg_from_image(image(MAPPINGS[name], people, rng))
            sender.publish(compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, name))
        return stamp_ns

    bench.answer(lambda: show(np.zeros((0, 2))), tracks)
    for people in [np.zeros((0, 2))] * 31 + [PLACE] * 13:
        stamp_ns = show(people)
        bench.until(lambda stamp_ns=stamp_ns: tracks[-1].stamp_ns >= stamp_ns)
    assert len(told[-1]) == 1600
    assert tracks[-1].status.tolist() == [TrackStatus.CONFIRMED]
    assert np.linalg.norm(tracks[-1].position[:, :2] - PLACE, axis=1) < 0.4
    bench.until(lambda: maps)
    assert maps[-1].info.width == maps[-1].info.height == 40
    assert max(maps[-1].data) > 20


def test_a_map_has_square_cells_that_lie_where_the_grid_does():
    x, y = (np.arange(4) + 0.5) * 0.15, (np.arange(4) + 0.5) * 0.3
    place = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    told = np.linspace(-4.5, 0, 16)
    told[3] = np.nan
    position = np.column_stack([place, np.zeros(16)])
    rows = Likelihood.build(5, position=position, log_likelihood=told)
    grid = likelihood_grid(rows, 'map')
    assert (grid.info.width, grid.info.height) == (4, 8)
    assert grid.info.resolution == pytest.approx(0.15)
    corner = grid.info.origin.position
    assert (corner.x, corner.y) == pytest.approx((0, 0), abs=1e-6)
    values = np.array(grid.data).reshape(8, 4)
    np.testing.assert_array_equal(values[::2], values[1::2])
    assert values[0, 3] == -1
    assert values[7, 3] == 100
    assert grid.header.stamp.nanosec == 5
