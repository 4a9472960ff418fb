"""Coverage by polygons against counts of random places, and its errors against simulation."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from lens_cameras import camera
from mctrack_ros.ground.camera.pinhole import PARAMETERS, CameraMapping
from mctrack_ros.ground.coverage.coverage import CoverageConfig, area_from, coverage_of
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, polygon_from, seen_ground
from mctrack_ros.ground.coverage.view import View

AREA = shapely.box(0, 0, 20, 10)
NUMBERS = st.floats(-4, 24).map(lambda value: round(value, 2))


@st.composite
def polygons(draw):
    """Draw a polygon: the hull of some points."""
    points = draw(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=3, max_size=8))
    hull = shapely.MultiPoint(points).convex_hull
    return hull if hull.geom_type == 'Polygon' else shapely.box(0, 0, 3, 3)


def covered(*fields, area=AREA, **settings):
    views = {f'cam{number}': View(field) for number, field in enumerate(fields, 1)}
    return coverage_of(views, area, CoverageConfig(**settings))


@settings(max_examples=60, deadline=None)
@given(st.lists(polygons(), min_size=1, max_size=6), st.integers(0, 2**31))
def test_levels_hold_the_places_that_so_many_fields_hold(fields, seed):
    coverage = covered(*fields, cell=1.0)
    places = np.random.default_rng(seed).uniform((0, 0), (20, 10), (500, 2))
    count = sum(shapely.contains_xy(field, *places.T).astype(int) for field in fields)
    edges = shapely.union_all([field.boundary for field in fields])
    clear = shapely.distance(edges, shapely.points(places)) > 0.02
    for number, level in enumerate(coverage.at_least, 1):
        assert (shapely.contains_xy(level, *places.T) == (count >= number))[clear].all()
    blind = shapely.contains_xy(shapely.MultiPolygon(coverage.blind), *places.T)
    assert (blind == (count == 0))[clear].all()


@settings(max_examples=60, deadline=None)
@given(st.lists(polygons(), min_size=1, max_size=6))
def test_cells_give_the_shares_of_the_polygons(fields):
    coverage = covered(*fields, cell=0.25)
    count, cells = coverage.raster.count, coverage.raster.inside.sum()
    edge = sum(field.length for field in fields)
    for number in range(1, len(fields) + 1):
        share = (count >= number).sum() / cells
        assert coverage.share(number) == pytest.approx(share, abs=0.25 * edge / AREA.area + 1e-3)
    exact = [coverage.share_of_exactly(number) for number in range(len(fields) + 1)]
    assert sum(exact) == pytest.approx(1.0)
    assert min(exact) > -1e-6


def test_blind_areas_come_largest_first():
    coverage = covered(shapely.box(2, 0, 5, 10), shapely.box(5, 0, 19, 10))
    assert [round(piece.area) for piece in coverage.blind] == [20, 10]
    assert coverage.blind[0].centroid.coords[0] == pytest.approx((1, 5))
    assert coverage.share_of_exactly(0) == pytest.approx(0.15)


def test_overlapping_cameras_hand_over_in_their_overlap():
    (hand_over,) = covered(shapely.box(0, 0, 8, 10), shapely.box(6, -5, 20, 10)).hand_overs
    assert hand_over.cameras == ('cam1', 'cam2')
    assert hand_over.zone.equals(shapely.box(6, 0, 8, 10))
    assert hand_over.gap == 0.0


def test_cameras_apart_adjoin_up_to_a_gap():
    fields = shapely.box(0, 0, 8, 10), shapely.box(8.5, 0, 20, 10)
    (hand_over,) = covered(*fields, adjoining=0.6).hand_overs
    assert hand_over.zone.is_empty
    assert hand_over.gap == pytest.approx(0.5)
    assert hand_over.border[:, 0] == pytest.approx([8, 8.5])
    assert covered(*fields, adjoining=0.4).hand_overs == ()


def test_overlap_outside_the_area_hands_nothing_over():
    coverage = covered(
        shapely.box(0, 0, 8, 30), shapely.box(12, 0, 20, 10).union(shapely.box(5, 15, 20, 20))
    )
    assert coverage.hand_overs == ()


def views_of(*cameras, noise=1.0):
    return {
        f'cam{number}': View(seen_ground(mapping, 80.0), mapping, noise, 0.0)
        for number, mapping in enumerate(cameras, 1)
    }


def test_error_is_the_spread_of_noisy_feet():
    cameras = camera((0, -15, 8), (10, 5, 0)), camera((20, -15, 8), (10, 5, 0))
    coverage = coverage_of(views_of(*cameras), AREA, CoverageConfig(cell=1.0))
    place = np.array([[10.5, 5.5]])
    random = np.random.default_rng(1)
    estimates, information = [], []
    for mapping in cameras:
        pixel = mapping.image_from_ground(place) + random.normal(0, 1.0, (20000, 2))
        estimates.append(mapping.ground_from_image(pixel))
        information.append(np.linalg.inv(np.cov(estimates[-1].T)))
    single = [np.sqrt(np.linalg.eigvalsh(np.cov(each.T))[-1]) for each in estimates]
    weighted = sum(each @ weight for each, weight in zip(estimates, information))
    fused = weighted @ np.linalg.inv(sum(information))
    assert coverage.raster.error[:, 5, 10] == pytest.approx(single, rel=0.03)
    assert coverage.raster.best[5, 10] == pytest.approx(min(single), rel=0.03)
    worst = np.sqrt(np.linalg.eigvalsh(np.cov(fused.T))[-1])
    assert coverage.raster.fused[5, 10] == pytest.approx(worst, rel=0.03)


def test_more_cameras_never_measure_worse():
    cameras = camera((0, -15, 8), (10, 5, 0)), camera((20, -15, 8), (10, 5, 0))
    raster = coverage_of(views_of(*cameras), AREA).raster
    known = np.isfinite(raster.best)
    assert (raster.fused[known] <= raster.best[known] + 1e-12).all()
    assert np.array_equal(known, raster.count > 0)


def test_calibration_adds_to_the_error():
    sure = camera((0, -15, 8), (10, 5, 0))
    covariance = np.diag([25.0 * (name == 'focal length') for name in PARAMETERS])
    unsure = CameraMapping(replace(sure.camera, covariance=covariance), sure.image_size)
    errors = [coverage_of(views_of(each), AREA).raster.fused for each in (sure, unsure)]
    known = np.isfinite(errors[0])
    assert (errors[1][known] > errors[0][known]).all()


def test_camera_without_calibration_counts_but_has_no_error():
    raster = covered(shapely.box(0, 0, 20, 5)).raster
    assert raster.count.sum() == raster.inside.sum() / 2
    assert np.isnan(raster.fused).all()
    assert np.isnan(raster.best).all()


def test_camera_that_sees_no_ground_changes_nothing():
    blind = camera((0, 0, 5), (0, 10, 20))
    seeing = camera((0, -15, 8), (10, 5, 0))
    with_it, without = coverage_of(views_of(seeing, blind)), coverage_of(views_of(seeing))
    assert with_it.share(1) == pytest.approx(without.share(1))
    assert with_it.fields[1].is_empty
    with pytest.raises(FieldOfViewError, match='no camera sees any ground'):
        coverage_of(views_of(blind))
    assert coverage_of(views_of(blind), AREA).share_of_exactly(0) == 1.0


def test_area_is_read_from_numbers():
    assert area_from('20,10, 0,0').equals(AREA)
    assert area_from('0,0,4,0,0,4').area == 8.0
    for text in ('', 'pitch', '0,0,4', '0,0,4,0,1'):
        with pytest.raises(FieldOfViewError, match='expected x0,y0,x1,y1'):
            area_from(text)
    for text in ('0,0,0,5', '0,0,2,2,2,0,0,2', '0,0,nan,5'):
        with pytest.raises(FieldOfViewError, match='the area '):
            area_from(text)


def test_too_many_cells_are_refused():
    with pytest.raises(FieldOfViewError, match='name a smaller area or larger cells'):
        covered(AREA, area=shapely.box(0, 0, 1000, 1000), cell=0.1)


def test_hole_in_the_area_is_not_covered():
    ring = polygon_from([[0, 0], [10, 0], [10, 10], [0, 10]]).difference(shapely.box(4, 4, 6, 6))
    coverage = covered(shapely.box(0, 0, 10, 10), area=ring)
    assert coverage.share(1) == pytest.approx(1.0)
    assert not coverage.raster.inside[9:11, 9:11].any()
