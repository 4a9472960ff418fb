import numpy as np
import pytest

from mctrack_experiments.real.street import FOLDER, read_truth, write_site


@pytest.mark.real_data
def test_feet_of_the_boxes_stand_where_the_truth_is(data_root, tmp_path):
    table = np.loadtxt(data_root / FOLDER / 'gt' / 'gt.txt', delimiter=',')
    left, top, width, height = table[:, 2:6].T
    mapping = write_site(data_root, tmp_path).cameras['street'].mapping()
    found = mapping.ground_from_image(np.column_stack([left + width / 2, top + height]))
    apart = np.linalg.norm(found - read_truth(data_root).position, axis=1)
    assert np.median(apart) < 0.1
