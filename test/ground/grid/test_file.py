import dataclasses

import numpy as np
import pytest

from lens_cameras import SIZE, camera
from mctrack_ros.ground import (
    METHODS,
    CalibrationError,
    GridError,
    TransformationGrid,
    grid_from_points,
    mapping_from_grid,
    read_grid,
    write_grid,
)


def square_grid(columns=4, rows=3, spacing=4.0, unit=1.0):
    """Return what a camera sees of a grid; lengths are multiplied by the unit."""
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    ground = np.column_stack([x.ravel() * spacing - 6.0, y.ravel() * spacing])
    image = camera().image_from_ground(ground)
    names = [f'{"ABCDEFGH"[row]}{column + 1}' for row, column in zip(y.ravel(), x.ravel())]
    return grid_from_points('cam1', names, ground * unit, image)[0]


def with_fov(grid, corners):
    return dataclasses.replace(grid, fov=np.array(corners, float))


@pytest.mark.parametrize('fov', [None, [(0.0, 0.0), (10.0, 0.1), (5.0, 1 / 3)]])
@pytest.mark.parametrize('size', [None, SIZE])
def test_a_grid_survives_its_file_and_is_written_back_identically(tmp_path, fov, size):
    grid = square_grid()
    names = (('a"<&', *grid.names[0][1:]), *grid.names[1:])
    grid = dataclasses.replace(grid, names=names, image_size=size)
    grid = grid if fov is None else with_fov(grid, fov)
    write_grid(grid, tmp_path / 'one.xml')
    back = read_grid(tmp_path / 'one.xml')
    assert (back.workstation, back.names, back.image_size) == ('cam1', names, size)
    np.testing.assert_array_equal(back.ground, grid.ground)
    np.testing.assert_array_equal(back.image, grid.image)
    assert (back.fov is None) if fov is None else (back.fov == grid.fov).all()
    write_grid(back, tmp_path / 'two.xml')
    assert (tmp_path / 'one.xml').read_bytes() == (tmp_path / 'two.xml').read_bytes()


POINT = '<point name="a" xr="0" yr="0" xi="1" yi="2"/>'
CELL = f'<cell id="0">{POINT * 4}</cell>'


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('this is no XML', 'not a readable XML file'),
        ('', 'not a readable XML file'),
        ('<scene/>', 'expected <workstation>'),
        ('<workstation id="1"/>', r'Expected is \( cell \)'),
        (f'<workstation>{CELL}</workstation>', "'id' is required but missing"),
        (f'<workstation id="">{CELL}</workstation>', 'minLength'),
        (f'<workstation id="1"><cell id="7">{POINT * 3}</cell></workstation>', 'point'),
        (f'<workstation id="1"><cell id="7">{POINT * 5}</cell></workstation>', 'point'),
        (f'<workstation id="1">{CELL.replace("xi=", "xj=", 1)}</workstation>', "'xj'"),
        (f'<workstation id="1">{CELL.replace(" xi=", " b=")}</workstation>', "'b' is not allowed"),
        (f'<workstation id="1">\n{CELL.replace(" name=", "", 1)}</workstation>', 'not a readable'),
        (f'<workstation id="1">\n{CELL.replace("0", "north", 2)}</workstation>', r":2: .*'north'"),
        (f'<workstation id="1">{CELL.replace("yi=.2", "")}</workstation>', 'has a point twice'),
        (
            f'<workstation id="1">{CELL.replace("1", "NaN", 1)}</workstation>',
            "'NaN', expected a number such as",
        ),
        (
            f'<workstation id="1">{CELL.replace("1", "INF", 1)}</workstation>',
            "'INF', expected a number such as",
        ),
        (f'<workstation id="1" width="7">{CELL}</workstation>', 'both width and height'),
        (f'<workstation id="1" width="0" height="1">{CELL}</workstation>', 'width'),
        (
            '<!DOCTYPE w [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
            f'<workstation id="&a;">{CELL}</workstation>',
            'document types and entities are refused',
        ),
        (
            '<!DOCTYPE w [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><workstation id="&b;"/>',
            'document types and entities are refused',
        ),
        (
            '<!DOCTYPE w SYSTEM "http://localhost/w.dtd"><workstation id="1"/>',
            'document types and entities are refused',
        ),
    ],
)
def test_grids_that_cannot_be_used_are_refused_by_file_and_reason(tmp_path, text, reason):
    path = tmp_path / 'grid.xml'
    path.write_text(text)
    with pytest.raises(GridError, match=reason) as refusal:
        read_grid(path)
    assert str(path) in str(refusal.value)
    assert '\n' not in str(refusal.value)


def test_a_missing_grid_is_named(tmp_path):
    with pytest.raises(GridError, match=r'grid.xml: No such file'):
        read_grid(tmp_path / 'grid.xml')


def moved(grid, name, ground=None, image=None):
    """Return the grid with a point at another place, everywhere it is named."""
    at = np.array(grid.names) == name
    places, pixels = grid.ground.copy(), grid.image.copy()
    if ground is not None:
        places[at] = ground
    if image is not None:
        pixels[at] = image
    return dataclasses.replace(grid, ground=places, image=pixels)


def swapped(grid, one, other):
    names, _, image = grid.named_points()
    first, second = image[names.index(one)], image[names.index(other)]
    return moved(moved(grid, one, image=second), other, image=first)


def renamed(grid, one, other):
    names = tuple(tuple(other if name == one else name for name in cell) for cell in grid.names)
    return dataclasses.replace(grid, names=names)


def flattened(grid):
    one = TransformationGrid(grid.workstation, grid.names[:1], grid.ground[:1], grid.image[:1])
    ground = np.array([[[0, 0], [1, 1], [2, 2], [3, 3.0]]])
    return dataclasses.replace(one, ground=ground)


GRID = square_grid()
PLACE, PIXEL = (part[0][0] for part in (GRID.ground, GRID.image))


@pytest.mark.parametrize(
    ('grid', 'reason'),
    [
        (swapped(GRID, 'B2', 'B3'), r"are 'B2' and 'B3' swapped\?"),
        (swapped(GRID, 'A1', 'C4'), r"are 'A1' and 'C4' swapped|two of them swapped"),
        (renamed(GRID, 'A1', 'B2'), 'has a point twice'),
        (renamed(GRID, 'A1', 'C4'), "'C4' has other coordinates here"),
        (moved(GRID, 'C4', ground=PLACE), "'A1' and 'C4' have the same place on the ground"),
        (moved(GRID, 'C4', image=PIXEL), "'A1' and 'C4' have the same pixel"),
        (flattened(GRID), 'lie on a line on the ground'),
        (
            dataclasses.replace(GRID, image=GRID.image * (1, 0) + GRID.image[..., :1] * (0, 0.5)),
            'lie on a line in the image',
        ),
        (square_grid(unit=100.0), r'400 m long.*centimetres'),
        (dataclasses.replace(GRID, image_size=(200, 100)), 'outside an image of 200 x 100'),
        (moved(dataclasses.replace(GRID, image_size=SIZE), 'A1', image=(-90, 500)), 'outside'),
        (
            with_fov(GRID, [(0, 0), (4, 4), (4, 0), (0, 4)]),
            'field of view crosses or touches itself',
        ),
        (with_fov(GRID, [(0, 0), (4, 4), (8, 8)]), 'no area: its corners lie on one line'),
        (with_fov(GRID, [(0, 0), (4, 4), (0, 0)]), '2 different corners, expected at least 3'),
    ],
)
def test_points_that_cannot_be_where_they_are_said_to_be_are_named(tmp_path, grid, reason):
    path = tmp_path / 'grid.xml'
    write_grid(grid, path)
    with pytest.raises(GridError, match=reason) as refusal:
        read_grid(path)
    assert str(path) in str(refusal.value)


def test_the_line_of_a_flaw_is_named(tmp_path):
    write_grid(renamed(GRID, 'A1', 'C4'), tmp_path / 'grid.xml')
    line = (tmp_path / 'grid.xml').read_text().splitlines().index('  <cell id="5">') + 1
    with pytest.raises(GridError, match=rf'grid\.xml:{line}: '):
        read_grid(tmp_path / 'grid.xml')


@pytest.mark.parametrize('method', METHODS)
def test_a_grid_for_another_image_size_is_refused(method):
    sized = dataclasses.replace(GRID, image_size=SIZE)
    mapping_from_grid(sized, SIZE, method)
    with pytest.raises(GridError, match='720 x 576 px, not of 1920 x 1080 px'):
        mapping_from_grid(sized, (1920, 1080), method)
    with pytest.raises(GridError, match='outside an image of 320 x 240 px'):
        mapping_from_grid(GRID, (320, 240), method)


@pytest.mark.parametrize('size', [(800, 400), (400, 800)])
@pytest.mark.parametrize('side', [(0, -1), (0, 1), (1, -1), (1, 1)])
def test_a_point_may_be_clicked_outside_by_a_twentieth_of_the_longer_side(size, side):
    axis, sign = side
    image = np.array([[[100.0, 100], [200, 100], [200, 200], [100, 200]]])
    grid = TransformationGrid('cam1', (('a', 'b', 'c', 'd'),), image / 10, image.copy())
    grid.image[0, 2, axis] = (size[axis] if sign > 0 else 0) + sign * 39.9
    grid.check_size(size)
    grid.image[0, 2, axis] += sign * 0.2
    with pytest.raises(GridError, match="point 'c' of cam1 at pixel"):
        grid.check_size(size)


@pytest.mark.parametrize('method', METHODS)
def test_centimetres_are_refused_with_a_hint(method):
    """A room: a fifth of the yard that the other tests look at, so the same in the image."""
    room = square_grid()
    room = dataclasses.replace(room, ground=room.ground * 0.2 * 100)
    with pytest.raises(CalibrationError, match='centimetres'):
        mapping_from_grid(room, SIZE, method)


def test_points_of_incomplete_cells_are_ignored_and_listed():
    names, ground, image = GRID.named_points()
    grid, ignored = grid_from_points('cam1', names[:-1], ground[:-1], image[:-1])
    left_out = [name for name in names[:-1] if not any(name in cell for cell in grid.names)]
    assert list(ignored) == left_out
    assert len(grid.names) == len(GRID.names) - 1


def test_a_row_that_was_not_clicked_leaves_a_gap_and_no_cell_of_twice_the_size():
    x, y = (each.ravel().astype(float) for each in np.meshgrid(range(0, 40, 8), range(0, 48, 8)))
    kept = y != 24
    ground = np.column_stack([x, y])[kept]
    names = [f'{a:g}/{b:g}' for a, b in ground]
    grid, ignored = grid_from_points('cam1', names, ground, ground * 10)
    assert (np.ptp(grid.ground, axis=1) == 8).all()
    assert len(grid.names) == 4 * 3
    assert ignored == ()


def test_rows_at_uneven_distances_make_cells_of_uneven_size():
    x, y = (each.ravel() for each in np.meshgrid([0.0, 5.5, 16.5], [0.0, 4.0, 12.0]))
    ground = np.column_stack([x, y])
    names = [f'{a:g}/{b:g}' for a, b in ground]
    assert len(grid_from_points('cam1', names, ground, ground * 10)[0].names) == 4


@pytest.mark.parametrize(
    ('names', 'column', 'value', 'reason'),
    [
        (['A1', 'A1'], 0, 1.0, 'is there twice'),
        (['A1', 'A2'], 0, np.nan, 'not finite'),
    ],
)
def test_clicked_points_are_checked(names, column, value, reason):
    ground = np.array([[0.0, 0.0], [1.0, 1.0]])
    ground[0, column] = value
    with pytest.raises(GridError, match=reason):
        grid_from_points('cam1', names, ground, np.array([[1.0, 2.0], [3.0, 4.0]]))


@pytest.mark.parametrize('note', ['<!-- by Anna -->', '<?note by Anna?>'])
@pytest.mark.parametrize('where', ['<cell id="0">', '<fov>'])
def test_notes_between_elements_are_passed_over(tmp_path, where, note):
    path, grid = tmp_path / 'cam.xml', with_fov(square_grid(), [(0, 0), (9, 0), (9, 9)])
    write_grid(grid, path)
    path.write_text(path.read_text().replace(where, where + note))
    np.testing.assert_array_equal(read_grid(path).image, grid.image)
    np.testing.assert_array_equal(read_grid(path).fov, grid.fov)
