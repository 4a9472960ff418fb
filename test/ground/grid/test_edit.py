import numpy as np
import pytest

from mctrack_ros.ground import GridError, read_grid, write_fov, write_grid

FOV = np.array([[0.0, 0.0], [10.0, 0.1], [5.0, 1 / 3]])
BY_HAND = """<?xml version='1.0' encoding='UTF-8'?>
<!-- yard, measured by Anna with the long tape -->
<workstation height="576" id='north'   width="720">
    <cell id="by the door">
        <point name='A1' yr="0" xr="0" xi="100.50" yi="500"/>  <!-- chalk -->
        <point xr="8" yr="0" xi="600" yi="500" name="A2"></point>
        <point name="B2" xr="8" yr="8.0" xi="5e2" yi="300" />
        <point name="B1" xr="0" yr="8" xi="200" yi="300"/>
    </cell>
    <?note until spring?>
{fov}</workstation>
<!-- end -->"""
DRAWN = """    <fov><corner xr="1" yr="2"/> <corner xr="3" yr="2"/><!-- wall -->
         <corner xr="3" yr="9"/></fov>
"""


def written(path, content):
    path.write_bytes(content.encode())
    return path


@pytest.mark.parametrize('newline', ['\n', '\r\n'])
@pytest.mark.parametrize('fov', ['', DRAWN])
def test_only_the_field_of_view_of_a_file_changes(tmp_path, fov, newline):
    text = BY_HAND.format(fov=fov).replace('\n', newline)
    path = written(tmp_path / 'north.xml', text)
    write_fov(FOV, path)
    np.testing.assert_array_equal(read_grid(path).fov, FOV)
    lines = path.read_bytes().decode().split(newline)
    first = lines.index('    <fov>')
    assert lines[first + 1 : first + 5] == [
        '        <corner xr="0.0" yr="0.0"/>',
        '        <corner xr="10.0" yr="0.1"/>',
        '        <corner xr="5.0" yr="0.3333333333333333"/>',
        '    </fov>',
    ]
    rest = newline.join(lines[:first] + lines[first + 5 :])
    assert rest == BY_HAND.format(fov='').replace('\n', newline)
    write_fov(None, path)
    assert path.read_bytes().decode() == rest


def test_a_file_in_one_line_takes_a_field_of_view(tmp_path):
    text = BY_HAND.replace('\n', ' ').format(fov='')
    path = written(tmp_path / 'north.xml', text)
    write_fov(FOV, path)
    np.testing.assert_array_equal(read_grid(path).fov, FOV)
    write_fov(None, path)
    assert path.read_text().split() == text.split()


def test_another_encoding_is_refused_and_the_file_left_alone(tmp_path):
    path = tmp_path / 'north.xml'
    path.write_bytes(BY_HAND.format(fov='').replace('UTF-8', 'UTF-16').encode('utf-16'))
    before = path.read_bytes()
    with pytest.raises(GridError, match='save it as UTF-8'):
        write_fov(FOV, path)
    assert path.read_bytes() == before


def test_cells_keep_their_ids(tmp_path):
    grid = read_grid(written(tmp_path / 'north.xml', BY_HAND.format(fov=DRAWN)))
    write_grid(grid, tmp_path / 'again.xml')
    assert read_grid(tmp_path / 'again.xml').cell_ids == ('by the door',)
