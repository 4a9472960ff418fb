import numpy as np
import pytest

from mctrack_ros.ground import (
    GridError,
    ProjectionError,
    TransformationGrid,
    read_grid,
    read_projection,
    write_grid,
)

POINT = '<point name="a" xr="0" yr="0" xi="1" yi="2"/>'
CELL = f'<cell id="0">{POINT * 4}</cell>'


def test_a_grid_survives_its_file(tmp_path):
    rng = np.random.default_rng(1)
    names = (('a', 'b"<', 'c', 'd'), ('e', 'f', 'g', 'h'))
    grid = TransformationGrid(
        'cam1', names, rng.normal(size=(2, 4, 2)), rng.normal(size=(2, 4, 2))
    )
    write_grid(grid, tmp_path / 'grid.xml')
    back = read_grid(tmp_path / 'grid.xml')
    assert back.workstation == 'cam1'
    assert back.names == names
    np.testing.assert_array_equal(back.ground, grid.ground)
    np.testing.assert_array_equal(back.image, grid.image)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('this is no XML', 'not a readable XML file'),
        ('', 'not a readable XML file'),
        ('<scene/>', 'expected <workstation>'),
        ('<workstation id="1"/>', 'the grid has no <cell>'),
        (f'<workstation><cell id="7">{POINT * 3}</cell></workstation>', "cell '7' has 3 points"),
        (f'<workstation>{CELL.replace("xi=", "xj=", 1)}</workstation>', 'lacks xi'),
        (
            f'<workstation>{CELL.replace("0", "north", 2)}</workstation>',
            'expected a finite number',
        ),
        (
            f'<workstation>{CELL.replace(chr(34) + "1", chr(34) + "nan", 1)}</workstation>',
            'finite',
        ),
        (
            '<!DOCTYPE w [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
            f'<workstation id="&a;">{CELL}</workstation>',
            'not a readable XML file',
        ),
        (
            '<!DOCTYPE w [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><workstation id="&b;"/>',
            'not a readable XML file',
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


HOMOGRAPHY = [[20.0, 1.0, 300.0], [0.5, -8.0, 400.0], [0.0, 0.02, 1.0]]


def test_both_directions_of_a_homography_mean_the_same(tmp_path):
    (tmp_path / 'one.yaml').write_text(f'image_from_ground: {HOMOGRAPHY}')
    inverse = np.linalg.inv(HOMOGRAPHY).tolist()
    (tmp_path / 'other.yaml').write_text(f'ground_from_image: {inverse}')
    one, other = (
        read_projection(tmp_path / name, (768, 576)) for name in ('one.yaml', 'other.yaml')
    )
    pixel = [[100.0, 400.0], [500.0, 350.0]]
    np.testing.assert_allclose(one.ground_from_image(pixel), other.ground_from_image(pixel))


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('{', 'not a readable YAML file'),
        ('homography: [[1]]', 'expected exactly one of the keys'),
        ('image_from_ground: [[1, 0], [0, 1]]', r'shape \(2, 2\), expected \(3, 3\)'),
        ('image_from_world: [[1, 0], [0]]', 'inhomogeneous'),
        ('image_from_ground: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]', 'singular'),
        ('ground_from_image: [[1, 0, 0], [1, 0, 0], [0, 0, 1]]', 'Singular'),
        ('image_from_ground: [[.nan, 0, 0], [0, 1, 0], [0, 0, 1]]', 'finite'),
    ],
)
def test_projections_that_cannot_be_used_are_refused_by_file_and_reason(tmp_path, text, reason):
    path = tmp_path / 'projection.yaml'
    path.write_text(text)
    with pytest.raises(ProjectionError, match=reason) as refusal:
        read_projection(path, (768, 576))
    assert str(path) in str(refusal.value)
    assert '\n' not in str(refusal.value)
