import numpy as np
import pytest

from mctrack_experiments.scenarios.staged.blind_area import blind_area
from mctrack_experiments.scenarios.staged.coalescence import coalescence
from mctrack_experiments.scenarios.staged.ghosts import ghost
from mctrack_experiments.scenarios.staged.hand_over import hand_over, stranger
from mctrack_experiments.scenarios.staged.rates import rate_figures, wilson
from mctrack_experiments.scenarios.staged.reproduce import SCENARIOS
from mctrack_experiments.scenarios.staged.stage import View, foot_covariance, merged
from mctrack_experiments.scenarios.staged.swapped_kits import swapped_kits


@pytest.mark.parametrize('kind', ['told', 'two_cameras'])
def test_a_ghost_dies_within_a_second(kind):
    assert ghost(1, kind, '')['dies']


def test_what_one_camera_alone_sees_where_others_look_is_never_reported():
    assert ghost(1, 'one_camera', '_credulous')['never']


@pytest.mark.parametrize('method', ['weighed_gnn', 'jpda'])
def test_two_of_one_kit_who_walk_side_by_side_stay_two(method):
    assert all(coalescence(1, 'side_by_side', 'same', method).values())


@pytest.mark.parametrize('gap', ['overlap', 'blind'])
def test_two_who_are_never_alone_keep_their_ids_from_camera_to_camera(gap):
    assert hand_over(1, gap, 'two_same')['kept']


def test_who_comes_out_of_a_blind_strip_in_another_kit_is_another():
    assert stranger(1, 'different')['told_apart']


@pytest.mark.parametrize('people', ['turns', 'two_different'])
def test_ids_last_through_an_area_that_no_camera_sees(people):
    assert blind_area(2, people)['kept']


def test_ids_swapped_in_a_scrum_are_corrected_and_published():
    outcome = swapped_kits(3, 'scrum')
    assert outcome == {'swapped': True, 'right': True, 'kept': True, 'corrected': True}


def test_those_who_look_the_same_are_left_as_they_are():
    outcome = swapped_kits(4, 'pair_alike')
    assert (outcome['swapped'], outcome['corrected']) == (True, False)


def test_a_seed_gives_the_same_outcome():
    assert ghost(2, 'two_cameras', '') == ghost(2, 'two_cameras', '')


def test_who_stands_behind_another_is_one_detection_with_him_in_their_middle():
    places = np.array([[10.0, 0.0], [12.0, 0.4], [10.0, 3.0]])
    target, other, shift = merged(places, np.arange(3), np.zeros(2))
    assert target.tolist() == [0, 2]
    assert other.tolist() == [1, -1]
    np.testing.assert_allclose(shift, [[0.0, 0.2], [0.0, 0.0]])


def test_feet_are_less_certain_along_the_line_of_sight():
    view = View((0.0, 0.0), (0.0, -5.0, 30.0, 5.0))
    (covariance,) = foot_covariance(np.array([[20.0, 0.0]]), np.array(view.position))
    assert covariance[0, 0] > covariance[1, 1] > 0
    assert covariance[0, 1] == pytest.approx(0.0)


def test_the_interval_of_a_rate_is_wilsons():
    assert wilson(0, 0) == (0.0, 1.0)
    assert wilson(50, 50)[1] == pytest.approx(1.0)
    assert wilson(45, 50) == pytest.approx((0.7864, 0.9565), abs=1e-4)
    assert rate_figures('x', [True, False])['x.rate'] == 0.5


def test_every_scenario_has_a_name_of_its_own():
    assert len(SCENARIOS) == len(set(SCENARIOS)) == 6 + 18 + 10 + 2 + 4 + 3
