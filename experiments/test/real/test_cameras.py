import pytest

from mctrack_experiments.real.cameras import reproduce_cameras


@pytest.mark.real_data
def test_real_calibrations_put_feet_where_people_stood(data_root):
    figures = reproduce_cameras(data_root).figures
    assert figures['pets.view1.median_m'] <= 0.05
    assert figures['pets.clicked12.worst_seed_m'] <= 0.15
    assert figures['wildtrack.worst_median_m'] <= 0.12
    assert figures['lab6p.largest_m'] <= 1e-6
