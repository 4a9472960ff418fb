"""The cameras of PETS: Tsai's lens, and feet that others detected."""

import gzip
import json

import numpy as np
import pytest
import shapely

from lens_cameras import missed
from mctrack_experiments.datasets.pets_multiview import annotated, read_truth
from mctrack_ros.ground import read_calibration, read_tsai, stated_size
from mctrack_ros.ground.coverage.field_of_view import seen_ground

VIEWS = range(1, 9)


@pytest.fixture(scope='module')
def pets(data_root):
    return data_root / 'pets2009_s2l1'


def view_file(pets, view):
    return pets / 'calibration' / f'View_{view:03d}.xml'


@pytest.mark.real_data
@pytest.mark.parametrize('view', VIEWS)
def test_every_view_of_pets_is_followed_where_people_walk(pets, view):
    path = view_file(pets, view)
    off, fold = missed(read_tsai(path))
    assert off[fold < 0.94].max() <= 0.1
    mapping = read_calibration(path, stated_size(path))
    truth = read_truth(pets).position
    pixel = mapping.image_from_ground(truth)
    inside = ((pixel >= 0) & (pixel <= mapping.image_size)).all(axis=1)
    assert inside.sum() > 2000
    assert shapely.contains_xy(seen_ground(mapping, 200.0), *truth[inside].T).mean() > 0.999
    np.testing.assert_allclose(mapping.ground_from_image(pixel[inside]), truth[inside], atol=1e-6)


@pytest.mark.real_data
@pytest.mark.parametrize(('view', 'most_m'), [(1, 0.2), (5, 0.4), (6, 0.35), (7, 0.42), (8, 0.42)])
def test_detected_feet_lie_where_view_1_says_that_people_stand(pets, view, most_m):
    path = view_file(pets, view)
    mapping, truth = read_calibration(path, stated_size(path)), read_truth(pets)
    name = f'keypointsrcnn_resnet50_fpn_View_{view:03d}_finetuned_2.json.gz'
    with gzip.open(pets / 'detections_multiview' / name, 'rt') as file:
        stored = json.load(file)
    counts = [len(boxes) for boxes in stored['bboxes']]
    frame = np.repeat(np.arange(1, len(counts) + 1), counts)
    boxes = np.concatenate([np.reshape(boxes, (-1, 4)) for boxes in stored['bboxes']])
    left, _, right, bottom = boxes.T
    foot = mapping.ground_from_image(np.column_stack([(left + right) / 2, bottom]))
    counted = annotated(pets, np.nan_to_num(foot, nan=1e6), truth)
    counted &= np.concatenate(stored['scores']) > 0.9
    away = []
    for each in np.intersect1d(frame[counted], truth.frame):
        apart = foot[counted & (frame == each), None] - truth.position[truth.frame == each]
        away.extend(np.linalg.norm(apart, axis=2).min(axis=1))
    assert len(away) > 2000
    assert np.median(away) <= most_m
