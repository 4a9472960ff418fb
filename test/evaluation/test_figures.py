import json

import numpy as np
import pytest

from mctrack_ros.evaluation.figures import Figures, FiguresError


def example():
    return Figures(
        'pets',
        'mctrack reproduce pets',
        {'gate_m': 1.0, 'frames': '398-795'},
        {'pets.pixels.moda': np.float64(0.8312345), 'pets.pixels.switches': np.int64(12)},
    )


def test_file_has_the_shape_of_the_design(tmp_path):
    example().write(tmp_path / 'deep' / 'pets.json')
    content = json.loads((tmp_path / 'deep' / 'pets.json').read_text())
    assert list(content) == ['name', 'command', 'protocol', 'figures']
    assert content['figures'] == {'pets.pixels.moda': 0.8312345, 'pets.pixels.switches': 12}
    assert 'CPUs' in content['protocol']['machine']


def test_what_is_written_is_read_back(tmp_path):
    example().write(tmp_path / 'a.json')
    assert Figures.read(tmp_path / 'a.json') == example()


def test_machine_of_a_file_is_not_replaced_by_the_reading_one(tmp_path):
    Figures('a', 'a', {'machine': 'another'}, {}).write(tmp_path / 'a.json')
    assert Figures.read(tmp_path / 'a.json').protocol['machine'] == 'another'


def test_value_that_does_not_exist_is_null(tmp_path):
    Figures('a', 'a', {}, {'b': float('nan')}).write(tmp_path / 'a.json')
    assert json.loads((tmp_path / 'a.json').read_text())['figures'] == {'b': None}
    assert np.isnan(Figures.read(tmp_path / 'a.json').figures['b'])


def test_table_aligns_names_and_values():
    lines = example().table().splitlines()
    assert lines[0] == 'pets'
    assert lines[-2:] == ['  pets.pixels.moda      0.831', '  pets.pixels.switches     12']


@pytest.mark.parametrize('text', ['', '[]', '{"name": "a"}', '{"figures": {"a": "b"}}'])
def test_other_file_is_refused_by_name(tmp_path, text):
    (tmp_path / 'a.json').write_text(text)
    with pytest.raises(FiguresError, match=r'a\.json holds no figures'):
        Figures.read(tmp_path / 'a.json')
