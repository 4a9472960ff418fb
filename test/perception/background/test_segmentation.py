import numpy as np
import pytest

from mctrack_ros.config import config_from
from mctrack_ros.perception import EventTracker, EventTrackerConfig
from mctrack_ros.perception.background.segmentation import inside_edges, otsu_threshold

RED = (30, 30, 220)


def test_otsu_parts_objects_from_noise_and_never_below_the_least():
    rng = np.random.default_rng(0)
    difference = np.abs(rng.normal(0, 3, (60, 80))).astype(np.uint8)
    assert otsu_threshold(difference, 12.0) == 12.0
    difference[10:40, 10:30] = rng.integers(60, 140, (30, 20))
    assert 12 <= otsu_threshold(difference, 12.0) < 60


def test_what_lies_outside_an_edge_is_cut():
    difference = np.zeros((40, 40), np.uint8)
    difference[10:30, 10:30] = 120
    halo = np.zeros_like(difference)
    halo[8:32, 8:32] = 255
    kept = inside_edges(halo, difference)
    assert (kept[11:29, 11:29] == 255).all()
    assert not kept[:9].any()
    assert not kept[:, 31:].any()


@pytest.mark.parametrize(
    'settings', [{'background': {'threshold': 'otsu'}}, {'blobs': {'edges': 'laplacian'}}]
)
def test_a_person_is_found_with_either(new_stage, mapping, settings):
    stage = new_stage()
    stage.pipeline = EventTracker(config_from(EventTrackerConfig, settings), mapping)
    stage.empty()
    for step in range(20):
        output = stage.show([((0.1 * step, 1.0), RED)])
    assert np.allclose(output.detections.position[:, :2], [[1.9, 1.0]], atol=0.3)
