import numpy as np
import pytest

from mctrack_experiments.real.intel import CARS, FOLDER, PEOPLE, SIZE, TUNED, counted


@pytest.mark.parametrize('clip', [CARS, PEOPLE])
def test_the_guessed_cameras_look_down_on_the_ground(clip):
    mapping = clip.mapping()
    middle, bottom = mapping.ground_from_image(
        [[SIZE[0] / 2, SIZE[1] / 2], [SIZE[0] / 2, SIZE[1]]]
    )
    assert middle[0] == pytest.approx(0.0, abs=1e-6)
    assert 0.0 < bottom[1] < middle[1]
    assert middle[1] == pytest.approx(clip.height_m / np.tan(np.deg2rad(clip.tilt_deg)))


def test_a_file_that_is_no_video_is_refused(tmp_path):
    (tmp_path / CARS.file).write_text('none')
    with pytest.raises(ValueError, match=CARS.file):
        counted(tmp_path, CARS, TUNED)


@pytest.mark.real_data
def test_each_car_is_counted_once_though_the_camera_changes_its_exposure(data_root):
    counts = counted(data_root / FOLDER, CARS, TUNED)
    assert (counts.vehicles, counts.pedestrians) == (CARS.true, 0)
