"""Tsai's lens, exactly as its author writes it, against OpenCV's that follows it."""

import cv2
import numpy as np
import pytest
import shapely

from lens_cameras import missed
from mctrack_ros.ground import (
    CalibrationError,
    TsaiCalibration,
    read_calibration,
    write_calibration,
)
from mctrack_ros.ground.coverage.field_of_view import seen_ground

SIZE = (720, 576)


def tsai(kappa1, centre=(360.0, 288.0)):
    """Return a camera that looks down from 10 m, forwards a little."""
    turn = cv2.Rodrigues(np.array([np.radians(150), 0, 0]))[0]
    per_mm = np.array([215.0, 215.0])
    shift = -turn @ [0.0, 0.0, 10.0]
    return TsaiCalibration(SIZE, 3.5, kappa1, per_mm, np.array(centre), turn, shift)


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


def test_a_lens_that_folds_much_of_the_image_is_refused():
    with pytest.raises(CalibrationError, match=r'folds 4\d% of the image over'):
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
