from pathlib import Path

import pytest

from mctrack_experiments.results import read_results, results_page
from mctrack_experiments.targets import TARGETS
from mctrack_ros.evaluation.figures import Figures, FiguresError

DOCS = Path(__file__).resolve().parents[2] / 'docs'


def lab6p(moda):
    return Figures('lab6p', 'mctrack reproduce lab6p', {'gate_m': 0.5}, {'lab6p.moda': moda})


def test_shipped_page_is_what_the_shipped_figures_give():
    assert (DOCS / 'results.md').read_text() == results_page(read_results(DOCS / 'results'))


def test_figure_stands_beside_its_target_and_anchor():
    page = results_page([lab6p(0.961)])
    assert '| `lab6p.moda` | 0.961 | ≥ 0.95 | yes | clustering and norfair: MOTA .947' in page
    assert '`mctrack reproduce lab6p`' in page
    assert 'gate_m: 0.5' in page


def test_figure_that_falls_short_says_so():
    assert '| ≥ 0.95 | **no** |' in results_page([lab6p(0.949)])
    assert '| ≥ 0.95 | **no** |' in results_page([lab6p(float('nan'))])


def test_target_without_a_figure_is_not_forgotten():
    page = results_page([])
    bounds = [target for target in TARGETS if target.text]
    assert page.count('not measured') == len(bounds)


def test_figures_without_a_target_are_listed_too():
    page = results_page([Figures('other', 'made | up', {'area': 'a|b'}, {'x': 3})])
    assert '| `x` | 3 |  |  |  |' in page
    assert 'area: a\\|b' in page


def test_targets_are_named_once_and_bounded_on_one_side():
    names = [(target.experiment, target.figure) for target in TARGETS]
    assert len(set(names)) == len(names)
    assert all(target.least is None or target.most is None for target in TARGETS)


def test_file_that_holds_no_figures_is_named(tmp_path):
    (tmp_path / 'a.json').write_text('{}')
    with pytest.raises(FiguresError, match=r'a\.json'):
        read_results(tmp_path)
