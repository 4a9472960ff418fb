import numpy as np
import pytest

from mctrack_experiments.real.pets_pixels import IMAGE_SIZE, TsaiCamera, pets_pixels, read_truth

pytestmark = pytest.mark.real_data


@pytest.fixture(scope='module')
def folder(data_root):
    return data_root / 'pets2009_s2l1'


def test_camera_puts_the_truth_into_the_image(folder):
    truth = read_truth(folder)
    camera = TsaiCamera(folder / 'calibration' / 'View_001.xml', IMAGE_SIZE)
    pixel = camera.mapping.image_from_ground(truth.position)
    assert ((pixel > -10) & (pixel < np.array(IMAGE_SIZE) + 10)).all()
    assert np.allclose(camera.mapping.ground_from_image(pixel), truth.position, atol=1e-6)


def test_undistortion_moves_the_corners_and_leaves_the_middle(folder):
    camera = TsaiCamera(folder / 'calibration' / 'View_001.xml', IMAGE_SIZE)
    column, row = camera.undistortion()
    assert abs(column[180, 240] - 240) < 0.5
    assert 1.0 < np.hypot(column[0, 0], row[0, 0]) < 12.0


def test_people_are_tracked_from_pixels_better_than_the_glue_does(folder):
    figures = pets_pixels(folder).figures
    assert figures['pets.pixels.moda'] >= 0.90
    assert figures['pets.pixels.mota'] >= 0.88
    assert figures['pets.pixels.idf1'] >= 0.70
    assert figures['pets.pixels.error_m'] <= 0.40
