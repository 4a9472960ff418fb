import numpy as np
import pytest

from mctrack_ros.ground import GridError, read_grid
from mctrack_ros.web import Pairing, PairingError
from web.scenes import CAMERA, block, paired, seen_points


def hall(**points):
    return Pairing('cam1', points or {'a': (0.0, 0.0), 'b': (1.0, 0.0)}, (640, 480))


def test_a_point_and_then_its_place_make_a_pair():
    pairing = hall()
    pairing.choose('b')
    assert pairing.is_placing
    pairing.place(10.25, 20.5)
    assert pairing.pairs == {'b': (10.25, 20.5)}
    assert (pairing.chosen, pairing.waiting) == ('', None)


def test_a_place_and_then_its_point_make_a_pair():
    pairing = hall()
    pairing.place(10, 20)
    assert pairing.pairs == {}
    pairing.choose('a')
    assert pairing.pairs == {'a': (10, 20)}


def test_a_click_beside_a_chosen_pair_does_not_move_it():
    pairing = hall()
    pairing.choose('a')
    pairing.place(10, 20)
    pairing.choose('a')
    pairing.place(300, 200)
    assert pairing.pairs == {'a': (10, 20)}
    assert pairing.waiting == (300, 200)


def test_every_step_is_taken_back_and_made_again():
    pairing = hall()
    pairing.choose('a')
    pairing.place(1, 2)
    pairing.move('a', 3, 4)
    pairing.delete('a')
    seen = []
    while pairing.can_undo:
        pairing.undo()
        seen.append(pairing.pairs)
    assert seen == [{'a': (3, 4)}, {'a': (1, 2)}, {}]
    while pairing.can_redo:
        pairing.redo()
        seen.append(pairing.pairs)
    assert seen[3:] == [{'a': (1, 2)}, {'a': (3, 4)}, {}]


def test_a_new_step_drops_those_taken_back():
    pairing = hall()
    pairing.choose('a')
    pairing.place(1, 2)
    pairing.undo()
    pairing.choose('b')
    pairing.place(5, 6)
    pairing.redo()
    assert pairing.pairs == {'b': (5, 6)}


@pytest.mark.parametrize(
    ('step', 'reason'),
    [
        (lambda p: p.choose('z'), "no point 'z'"),
        (lambda p: p.place(-1, 5), 'outside the image'),
        (lambda p: p.place(float('nan'), 5), 'outside the image'),
        (lambda p: p.move('a', 5, 5), 'has no place'),
        (lambda p: p.delete('a'), 'has no place'),
    ],
)
def test_a_step_that_makes_no_sense_is_refused_and_changes_nothing(step, reason):
    pairing = hall()
    with pytest.raises(PairingError, match=reason):
        step(pairing)
    assert pairing.pairs == {}
    assert not pairing.can_undo


def test_a_scene_without_points_is_refused():
    with pytest.raises(PairingError, match='no points'):
        Pairing('cam1', {}, (640, 480))


def test_there_is_no_camera_until_the_points_suffice_and_it_is_said_why():
    names = block()
    few = paired(names[:4])
    assert few.fit is None
    assert 'under-determined' in few.reason
    assert few.residual_px() == {}
    enough = paired(names)
    assert enough.reason == ''
    assert enough.fit.rms_px < 0.05


def test_a_point_far_off_is_the_suspicious_one():
    names = block()
    pairing = paired(names)
    x, y = pairing.pairs[names[5]]
    pairing.move(names[5], x + 14, y)
    assert pairing.suspicious() == (names[5],)
    pairing.undo()
    assert pairing.suspicious() == ()


def test_what_is_saved_holds_the_complete_cells_alone(tmp_path):
    names = [*block(), '6-6']
    pairing = paired(names)
    assert pairing.save(tmp_path / 'cam1.xml') == ('6-6',)
    grid = read_grid(tmp_path / 'cam1.xml')
    assert (grid.workstation, grid.image_size) == ('cam1', CAMERA.size)
    ground, image = grid.points()
    assert len(ground) == 12
    height = np.zeros((12, 1))
    np.testing.assert_allclose(CAMERA.project(np.hstack([ground, height])), image, atol=0.01)


def test_without_a_complete_cell_nothing_is_written(tmp_path):
    for names in ([], ['1-4', '2-4', '1-5']):
        with pytest.raises(GridError):
            paired(names).save(tmp_path / 'cam1.xml')
    assert not (tmp_path / 'cam1.xml').exists()


def test_swapped_points_are_not_saved(tmp_path):
    names = block(2, 2)
    _, image = seen_points()
    image[names[0]], image[names[1]] = image[names[1]], image[names[0]]
    with pytest.raises(GridError, match=names[0]):
        paired(names, image).save(tmp_path / 'cam1.xml')


def test_centimetres_for_metres_are_refused_with_a_hint():
    ground, image = seen_points()
    scene = {name: (100 * x, 100 * y) for name, (x, y) in ground.items()}
    pairing = Pairing('cam1', scene, CAMERA.size)
    for name in block():
        pairing.choose(name)
        pairing.place(*image[name])
    assert pairing.fit is None
    assert 'centimetres' in pairing.reason


def test_a_saved_grid_is_continued(tmp_path):
    pairing = paired(block())
    pairing.save(tmp_path / 'cam1.xml')
    again = paired([])
    again.resume(read_grid(tmp_path / 'cam1.xml'))
    assert again.pairs.keys() == pairing.pairs.keys()
    assert all(again.pairs[name] == pairing.pairs[name] for name in pairing.pairs)
    again.undo()
    assert again.pairs == {}


def test_the_grid_of_another_camera_or_scene_is_not_continued(tmp_path):
    paired(block()).save(tmp_path / 'cam1.xml')
    grid = read_grid(tmp_path / 'cam1.xml')
    ground, _ = seen_points()
    with pytest.raises(PairingError, match="not of 'cam2'"):
        Pairing('cam2', ground, CAMERA.size).resume(grid)
    moved = {name: (x + 1, y) for name, (x, y) in ground.items()}
    with pytest.raises(PairingError, match='the scene has not'):
        Pairing('cam1', moved, CAMERA.size).resume(grid)
