"""The coverage node: two grids, latched."""

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid

from far_hall import write_far_hall
from mctrack_ros.ros.graph.graph import coverage_node
from mctrack_ros.ros.nodes.coverage_node import CoverageNode
from mctrack_ros.ros.topics.quality import latched
from mctrack_ros.site.coverage import site_coverage
from mctrack_ros.site.site import load_site
from walker import SIZE

pytestmark = pytest.mark.live


@pytest.fixture
def site(tmp_path, projection):
    """Return the file of a site of two cameras that see the same, and an area beyond it."""
    camera = {'image_width': SIZE[0], 'image_height': SIZE[1], 'calibration': projection.name}
    content = {'ground_frame': 'hall', 'area': '-30,-30,30,40', 'cameras': {}}
    content['cameras'] = {'cam1': camera, 'cam2': camera}
    path = tmp_path / 'site.yaml'
    path.write_text(yaml.safe_dump(content))
    return path


def cells(grid):
    return np.reshape(grid.data, (grid.info.height, grid.info.width))


def test_late_comers_get_both_grids(bench, site):
    bench.make(CoverageNode, site=str(site), coverage={'cell': 1.0})
    bench.heard('/coverage')
    seen = bench.messages(OccupancyGrid, '/coverage', latched())
    error = bench.messages(OccupancyGrid, '/coverage/error', latched())
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    bench.until(lambda: seen and error and reports)
    raster = site_coverage(load_site(site)).raster
    info = seen[0].info
    assert seen[0].header.frame_id == 'hall'
    assert (info.width, info.height, info.resolution) == (60, 70, 1.0)
    assert (info.origin.position.x, info.origin.position.y) == (-30.0, -30.0)
    assert set(np.unique(cells(seen[0]))) == {0, 100}
    assert (cells(seen[0]) == 100).mean() == pytest.approx(raster.seen[0].mean(), abs=0.02)
    assert ((cells(error[0]) == -1) == (cells(seen[0]) == 0)).all()
    assert 0 < cells(error[0]).max() <= 100


def test_grids_of_a_far_site_are_told_from_its_origin(bench, tmp_path):
    site = write_far_hall(tmp_path / 'far', (389010.0, 5820020.0))
    bench.make(CoverageNode, site=str(tmp_path / 'far' / 'site.yaml'), coverage={'cell': 1.0})
    seen = bench.messages(OccupancyGrid, '/coverage', latched())
    bench.until(lambda: seen)
    assert site.origin == (389000.0, 5820000.0)
    corner = seen[0].info.origin.position
    assert (corner.x, corner.y) == pytest.approx((10.0 - 6.0, 20.0 - 6.0), abs=1e-6)


def test_corner_outside_a_slanted_area_is_unknown(bench, site):
    bench.make(CoverageNode, site=str(site), area='0,0,10,0,0,10', coverage={'cell': 1.0})
    seen = bench.messages(OccupancyGrid, '/coverage', latched())
    bench.until(lambda: seen)
    assert cells(seen[0])[9, 9] == -1
    assert cells(seen[0])[0, 0] != -1


def test_it_runs_from_the_site_s_file_alone(bench, site, tmp_path):
    spec = coverage_node(site)
    process = bench.spawn(spec.executable, **spec.parameters)
    bench.open()
    seen = bench.messages(OccupancyGrid, '/coverage', latched())
    bench.until(lambda: seen)
    assert process.poll() is None


def test_crossing_area_ends_it_with_its_reason(refusal, site):
    line = refusal('coverage_node', site=str(site), area='0,0,9,9,9,0,0,5')[-1]
    assert 'the area crosses or touches itself near' in line
