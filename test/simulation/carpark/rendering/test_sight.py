import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode, EventCode
from mctrack_ros.simulation import EventWatcher, parked_detections, true_detections
from mctrack_ros.simulation.carpark import CarParkRenderer

PERSON, RIDER, CAR = ClassCode.PERSON, ClassCode.BICYCLE, ClassCode.VEHICLE
PLACE = np.array([20.0, 14.0])


def visible(world, step=0):
    _, view = CarParkRenderer(world, 0).frame(step)
    return dict(zip(view.person.tolist(), view.visible.tolist()))


@pytest.mark.parametrize('heading', [0.0, 0.8])
def test_a_car_hides_whom_it_is_before_and_not_whom_it_is_behind(scene, heading):
    behind = visible(scene((CAR, PLACE, heading), (PERSON, PLACE - [-0.3, -3.0], 0.0)))
    before = visible(scene((CAR, PLACE, heading), (PERSON, PLACE - [0.3, 3.0], 0.0)))
    assert behind[1] < 0.9
    assert behind[0] == 1.0
    assert before[1] == 1.0
    assert before[0] < 1.0


def test_somebody_between_two_parked_cars_is_before_one_and_behind_the_other(scene):
    row = [(CAR, (12.0 + 2.6 * x, 14.0), np.pi / 2) for x in (0, 1)]
    shares = visible(scene(*row, (PERSON, (13.3, 14.0), 0.0)))
    assert shares[2] < 1.0
    assert min(shares[0], shares[1]) < 1.0


@pytest.mark.parametrize('kind', [PERSON, RIDER])
def test_pixels_change_only_inside_the_true_box(scene, kind):
    quiet = {'noise': 1e-3, 'shadows': False}
    empty, _ = CarParkRenderer(scene((CAR, (-200.0, 0.0), 0.0), **quiet), 0).frame(0)
    given = ((CAR, (-200.0, 0.0), 0.0), (kind, PLACE, 0.0))
    image, view = CarParkRenderer(scene(*given, **quiet), 0).frame(0)
    rows, columns = np.nonzero(image != empty)
    left, top, width, height = view.box[0]
    assert left <= columns.min() <= columns.max() < left + width
    assert top <= rows.min() <= rows.max() < top + height


def test_images_are_grey_and_do_not_depend_on_the_order(scene):
    given = [(CAR, PLACE, 0.0), (PERSON, PLACE - [0, 3.0], 0.0)]
    forwards, backwards = (CarParkRenderer(scene(*given), 0) for _ in range(2))
    first = [forwards.frame(step)[0] for step in (1, 5)]
    second = [backwards.frame(step)[0] for step in (5, 1)]
    assert first[0].shape == (480, 640)
    np.testing.assert_array_equal(first, second[::-1])


def test_a_parked_car_is_truth_of_its_own(scene):
    world = scene((CAR, PLACE, 0.0), (PERSON, PLACE - [0, 3.0], 0.0))
    _, view = CarParkRenderer(world, 0).frame(3)
    assert true_detections(world, 3, view).track_id.tolist() == [2]
    assert true_detections(world, 3, view).class_id.tolist() == [PERSON]
    assert parked_detections(world, 3, view).track_id.tolist() == [1]


def test_parked_cars_neither_touch_nor_happen(scene):
    walk = PLACE + np.column_stack([np.linspace(-9, 9, 60), np.full(60, -1.5)])
    world = scene((CAR, PLACE, 0.0), (PERSON, walk, 0.0), steps=60)
    renderer, watcher = CarParkRenderer(world, 0), EventWatcher(world, 0)
    codes = []
    for step in range(60):
        codes += watcher.step(step, renderer.frame(step)[1]).event.tolist()
    assert codes == [EventCode.NEW]


def test_walkers_that_pass_one_another_merge_and_split(scene):
    steps = np.linspace(-5, 5, 60)
    one = PLACE + np.column_stack([steps, np.zeros(60)])
    other = PLACE + np.column_stack([-steps, np.full(60, 0.4)])
    world = scene((PERSON, one, 0.0), (PERSON, other, np.pi), steps=60)
    renderer, watcher = CarParkRenderer(world, 0), EventWatcher(world, 0)
    codes = []
    for step in range(60):
        codes += watcher.step(step, renderer.frame(step)[1]).event.tolist()
    assert codes == [EventCode.NEW, EventCode.NEW, EventCode.MERGE, EventCode.SPLIT]


def test_a_bicycle_is_long_from_the_side_and_as_wide_as_its_rider_from_the_front(scene):
    def box(kind, heading):
        return CarParkRenderer(scene((kind, PLACE, heading)), 0).frame(0)[1].box[0]

    side, front, walker = box(RIDER, 0.0), box(RIDER, np.pi / 2), box(PERSON, np.pi / 2)
    assert side[2] > 2 * front[2]
    assert front[2] < 1.5 * walker[2]
    assert side[3] == pytest.approx(walker[3], rel=0.15)
