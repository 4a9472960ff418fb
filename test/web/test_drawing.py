import numpy as np
import pytest

from mctrack_ros.web import image_drawing, plan_drawing
from mctrack_ros.web.drawing import ARROW_SCALE
from mctrack_ros.web.lines import grid_step
from web.scenes import CAMERA, block, paired


def kinds(drawing):
    return {mark.name: mark.kind for mark in drawing.marks}


def test_without_a_camera_only_the_pairs_are_drawn_over_the_image():
    drawing = image_drawing(paired(block()[:3]))
    assert list(kinds(drawing).values()) == ['paired'] * 3
    assert drawing.lines == drawing.arrows == []
    assert all(mark.movable for mark in drawing.marks)


def test_the_metre_grid_lies_where_the_true_camera_sees_it():
    drawing = image_drawing(paired(block()))
    points = np.concatenate([line.points for line in drawing.lines])
    ground = CAMERA.ground(points)
    off = np.abs(ground / 10 - np.round(ground / 10)).min(axis=1) * 10
    assert len(points) > 100
    assert off.max() < 0.2


def test_points_without_a_place_are_expected_where_the_camera_sees_them():
    marks = [m for m in image_drawing(paired(block())).marks if m.kind == 'expected']
    assert len(marks) == 48
    assert not any(mark.movable for mark in marks)


def test_arrows_lead_from_the_click_to_where_the_camera_sees_the_point():
    names = block()
    pairing = paired(names)
    x, y = pairing.pairs[names[0]]
    pairing.move(names[0], x + 20, y)
    start, end = image_drawing(pairing).arrows[0].points
    assert start == pytest.approx([x + 20, y])
    assert (start[0] - end[0]) / ARROW_SCALE == pytest.approx(20, abs=3)
    assert kinds(plan_drawing(pairing))[names[0]] == 'chosen'
    pairing.forget()
    assert kinds(plan_drawing(pairing))[names[0]] == 'suspicious'


def test_the_plan_shows_what_is_paired_chosen_and_free():
    pairing = paired(['1-4'])
    pairing.choose('2-4')
    found = kinds(plan_drawing(pairing))
    assert [found[name] for name in ('1-4', '2-4', '3-4')] == ['paired', 'chosen', 'free']
    assert len(found) == len(pairing.names)


def test_a_place_that_waits_is_drawn():
    pairing = paired([])
    pairing.place(100, 50)
    assert kinds(image_drawing(pairing)) == {'?': 'waiting'}


@pytest.mark.parametrize(('extent', 'step'), [(105, 10), (8, 1), (1.3, 0.1), (27, 2), (0, 0.0001)])
def test_the_metre_grid_has_round_steps(extent, step):
    assert grid_step(np.array([(0.0, 0.0), (extent, extent / 2)])) == pytest.approx(step)
