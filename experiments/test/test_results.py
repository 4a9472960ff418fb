import re
from pathlib import Path

import pytest

from mctrack_experiments.definitions import definition_of, is_outdated
from mctrack_experiments.results import read_results, results_page
from mctrack_experiments.runs import Run, read_runs
from mctrack_experiments.targets import TARGETS
from mctrack_ros.evaluation.figures import Figures, FiguresError

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / 'docs'
README_FIGURES = {
    'EPFL terrace, four cameras': (
        'terrace4', 'terrace4.mota', 'terrace4.idf1', 'terrace4.gate_half_metre.moda'
    ),
    'EPFL terrace, two videos': ('terrace', 'terrace.mota', 'terrace.idf1'),
    'PETS S2.L1, one camera': (
        'pets', 'pets.pixels.moda', 'pets.pixels.mota', 'pets.pixels.idf1'
    ),
    'PETS S2.L1, six views': (
        'pets', 'pets.multiview.moda', 'pets.multiview.mota', 'pets.multiview.idf1'
    ),
    'WILDTRACK': (
        'wildtrack', 'wildtrack.mota', 'wildtrack.idf1', 'wildtrack.perfect.mota',
        'wildtrack.perfect.idf1',
    ),
    'EPFL laboratory': ('lab6p', 'lab6p.mota', 'lab6p.idf1'),
    'CMC1; CMC2': ('cmc', 'cmc1.mota', 'cmc1.idf1', 'cmc2.mota', 'cmc2.idf1'),
    'synthetic pitch, live': ('demo', 'mota', 'idf1'),
}  # fmt: skip


def lab6p(moda):
    return Figures('lab6p', 'mctrack reproduce lab6p', {'gate_m': 0.5}, {'lab6p.moda': moda})


def test_shipped_page_is_what_the_shipped_figures_give():
    shipped = results_page(read_results(DOCS / 'results'), read_runs(DOCS / 'runs.json'))
    assert (DOCS / 'results.md').read_text() == shipped


@pytest.mark.parametrize('data', README_FIGURES)
def test_figures_of_the_readme_are_those_measured(data):
    name, *wanted = README_FIGURES[data]
    measured = Figures.read(DOCS / 'results' / f'{name}.json')
    figures, number = measured.figures, measured.protocol.get('definition', 1)
    lines = (ROOT / 'README.md').read_text().splitlines()
    cells = next(line for line in lines if line.startswith(f'| {data}')).split(' | ')
    assert ('†' in cells[0]) == is_outdated(name, wanted[0], number)
    shown = re.findall(r'\.\d{3}', cells[2])
    assert shown == [f'{figures[each]:.3f}'.lstrip('0') for each in wanted]


def test_figure_stands_beside_its_target_its_peers_and_its_file():
    page = results_page([lab6p(0.961)])
    row = next(line for line in page.splitlines() if 'MODA at 0.5 m' in line and 'lab6p' in line)
    assert row.startswith('| [lab6p](results/lab6p.json) |')
    assert '| 0.961 |  | ≥ 0.95 | yes | clustering and norfair: MOTA .947' in row


def test_figure_that_falls_short_says_so():
    assert '| ≥ 0.95 | **no** |' in results_page([lab6p(0.949)])
    assert '| ≥ 0.95 | **no** |' in results_page([lab6p(float('nan'))])


def pairs(number, **protocol):
    return Figures('pairs', 'mctrack reproduce pairs', protocol, {'same.kept': number})


def test_figure_by_an_older_definition_is_marked_and_meets_nothing():
    page = results_page([pairs(0.99)])
    assert '| 0.990† |  | ≥ 0.85 | old definition |' in page
    assert '* † `pairs`, since changed: fresh seeds' in page
    page = results_page([pairs(0.99, definition=definition_of('pairs'))])
    assert '| 0.990 |  | ≥ 0.85 | yes |' in page
    assert '† `pairs`' not in page


def test_figure_that_the_older_definition_lacks_is_not_forgotten():
    old = Figures('table4', 'mctrack reproduce table4', {}, {'mota': 0.98})
    assert '| the same, F1 within 2 s | not yet† |' in results_page([old])


def test_only_the_figures_that_a_change_concerns_are_marked():
    assert is_outdated('covering', 'beside.gain.covering_text', 1)
    assert not is_outdated('covering', 'pets.covering_text.mota', 1)
    assert not is_outdated('lab6p', 'lab6p.mota', 1)


def test_mean_and_spread_of_all_runs_stand_beside_the_last():
    now = definition_of('pairs')
    runs = [
        Run('pairs', k, '2026-01-01', number, '1-5', {'same.kept': value})
        for k, number, value in ((0, 1, 0.1), (1, now, 0.8), (2, now, 0.9), (3, now - 1, 0.2))
    ]
    assert '| 0.900 | 0.850 ± 0.071 (2) |' in results_page([pairs(0.9, definition=now)], runs)


def test_target_without_a_figure_is_not_forgotten():
    page = results_page([])
    assert page.count('not measured') == sum(bool(one.text or one.anchor) for one in TARGETS)


def test_peer_that_was_measured_in_the_same_run_is_shown_by_its_value():
    now = {'definition': definition_of('bench_fusion')}
    peer = {'base.mota': 0.999, 'base.norfair.mota': 0.997}
    page = results_page([Figures('bench_fusion', 'mctrack bench fusion', now, peer)])
    assert '| 0.999 |  | ≥ 0.998 | yes | norfair: 0.997 |' in page


def test_every_experiment_of_the_page_has_its_file():
    page = (DOCS / 'results.md').read_text()
    assert 'not measured' not in page
    assert all((DOCS / name).exists() for name in re.findall(r'results/\w+\.json', page))


def test_targets_are_named_once_and_bounded_on_one_side():
    names = [(target.experiment, target.figure) for target in TARGETS]
    assert len(set(names)) == len(names)
    assert all(target.least is None or target.most is None for target in TARGETS)


def test_file_that_holds_no_figures_is_named(tmp_path):
    (tmp_path / 'a.json').write_text('{}')
    with pytest.raises(FiguresError, match=r'a\.json'):
        read_results(tmp_path)
