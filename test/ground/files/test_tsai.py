"""Tsai's lens, exactly as its author writes it, against OpenCV's that follows it."""

import gzip
import json

import cv2
import numpy as np
import pytest
import shapely

from mctrack_ros.experiments.datasets.pets_multiview import annotated, read_truth
from mctrack_ros.ground import (
    CalibrationError,
    TsaiCalibration,
    read_calibration,
    read_tsai,
    stated_size,
    write_calibration,
)
from mctrack_ros.ground.coverage.field_of_view import seen_ground

SIZE = (720, 576)
VIEWS = range(1, 9)


def tsai(kappa1, centre=(360.0, 288.0)):
    """Return a camera that looks down from 10 m, forwards a little."""
    turn = cv2.Rodrigues(np.array([np.radians(150), 0, 0]))[0]
    per_mm = np.array([215.0, 215.0])
    shift = -turn @ [0.0, 0.0, 10.0]
    return TsaiCalibration(SIZE, 3.5, kappa1, per_mm, np.array(centre), turn, shift)


def missed(stored):
    """Return, for pixels all over the picture, how far the lens misses and the share of a fold."""
    axes = [np.linspace(0, side, side // 8) for side in stored.image_size]
    pixel = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    sensor = (pixel - stored.centre) / stored.per_mm
    square = (sensor**2).sum(axis=1, keepdims=True)
    ideal = sensor * (1 + stored.kappa1 * square) / stored.focal_mm
    camera = stored.camera()
    across, down, x, y = camera.intrinsics
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1]])
    world = np.column_stack([ideal, np.ones(len(ideal))])
    seen = cv2.projectPoints(world, np.zeros(3), np.zeros(3), matrix, camera.distortion)[0]
    fold = np.sqrt(np.maximum(-3 * stored.kappa1 * square[:, 0], 0))
    return np.linalg.norm(seen[:, 0] - pixel, axis=1), fold


@pytest.mark.parametrize('kappa1', [-0.04, -0.02, -0.005, 0.0, 0.005, 0.03, 0.1])
@pytest.mark.parametrize('centre', [(360.0, 288.0), (590.0, 400.0)])
def test_every_lens_that_does_not_fold_is_followed_closely(kappa1, centre):
    stored = tsai(kappa1, centre)
    off, fold = missed(stored)
    if fold.max() > 0.9:
        return
    assert off.max() < 0.06
    assert off.max() <= stored.camera().lens_residual_px * 1.01 + 1e-9


def test_a_lens_that_folds_in_the_corners_is_followed_up_to_there():
    stored = tsai(-0.062, (430.0, 260.0))
    off, fold = missed(stored)
    assert fold.max() > 1.05
    assert off[fold < 0.97].max() < 0.2
    assert off[fold < 0.94].max() < 0.1
    assert off[fold < 0.97].max() <= stored.camera().lens_residual_px * 1.01


def test_what_the_fold_hides_is_no_ground_that_is_seen():
    mapping = tsai(-0.062, (430.0, 260.0)).camera().mapping(SIZE)
    region = seen_ground(mapping, 60.0)
    assert region.area > 50
    pixel = mapping.image_from_ground(shapely.get_coordinates(region.exterior))
    sensor = np.linalg.norm((pixel - (430, 260)) / 215.0, axis=1)
    assert np.sqrt(3 * 0.062) * sensor.max() < 0.97


def test_a_lens_that_folds_much_of_the_picture_is_refused():
    with pytest.raises(CalibrationError, match=r'folds 4\d% of the picture over'):
        tsai(-0.2).camera()


@pytest.mark.parametrize(
    ('to', 'kappa1'),
    [
        ('camera_info', -0.062),
        ('camera_info', 0.03),
        ('opencv', -0.062),
        ('tsai', 0.03),
        ('tsai', -0.062),
    ],
)
def test_a_strong_lens_survives_the_files_that_hold_it(tmp_path, to, kappa1):
    mapping = tsai(kappa1, (430.0, 260.0)).camera().mapping(SIZE)
    path = tmp_path / ('a.xml' if to == 'tsai' else 'a.yaml')
    missed = write_calibration(mapping, path, to, 'a')
    again = read_calibration(path, SIZE)
    assert missed < 0.5
    pixel = np.array([[300.0, 300], [100, 200], [600, 400], [70, 80]])
    ground = mapping.ground_from_image(pixel)
    back = again.image_from_ground(ground)
    np.testing.assert_allclose(back, pixel, atol=2 * missed + 1e-9)


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
    away = []
    for frame, (boxes, scores) in enumerate(zip(stored['bboxes'], stored['scores']), 1):
        left, _, right, bottom = np.reshape(boxes, (-1, 4))[np.array(scores) > 0.9].T
        foot = mapping.ground_from_image(np.column_stack([(left + right) / 2, bottom]))
        people = truth.position[truth.frame == frame]
        foot = foot[annotated(pets, np.nan_to_num(foot, nan=1e6), truth)]
        if len(foot) and len(people):
            away.extend(np.linalg.norm(foot[:, None] - people, axis=2).min(axis=1))
    assert len(away) > 2000
    assert np.median(away) <= most_m
