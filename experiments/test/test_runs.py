import pytest

from mctrack_experiments.definitions import definition_of
from mctrack_experiments.runs import (
    RunsError,
    listed,
    measured,
    next_number,
    numbers,
    read_runs,
    run_of,
    seeds_of,
    spread_of,
    spread_table,
    write_runs,
)
from mctrack_ros.evaluation.figures import Figures


def kept(number, value=0.9):
    figures = Figures('pairs', 'x', {}, {'same.kept': value, 'same.cases': 8})
    return run_of(figures, number, seeds_of('pairs', number))


def test_every_run_has_seeds_of_its_own():
    assert seeds_of('table4', 1) == (1001, 1002, 1003, 1004, 1005)
    seeds = [set(seeds_of('scenarios', number)) for number in range(1, 4)]
    assert not seeds[0] & seeds[1]
    assert not seeds[1] & seeds[2]
    assert min(seeds[0]) > 1000  # whatever was tuned on lies below


def test_runs_are_counted_for_each_experiment():
    assert next_number([], 'pairs') == 1
    assert next_number([kept(0)], 'pairs') == 1  # on worn seeds
    assert next_number([kept(1), kept(2)], 'pairs') == 3
    assert next_number([kept(1), kept(2)], 'table4') == 1


def test_runs_come_back_from_their_file_as_they_were_written(tmp_path):
    path = tmp_path / 'runs.json'
    assert read_runs(path) == []
    write_runs([kept(1), kept(2)], path)
    assert read_runs(path) == [kept(1), kept(2)]
    assert len(path.read_text().splitlines()) == 4  # one a line, and brackets
    assert kept(1).figures == {'same.kept': 0.9}  # what has no target is not kept
    path.write_text('[{"a": 1}]')
    with pytest.raises(RunsError, match=r'runs\.json'):
        read_runs(path)


def test_mean_and_spread_are_over_runs_on_fresh_seeds():
    runs = [kept(0, 0.1), kept(1, 0.8), kept(2, 1.0)]
    spread = spread_of(runs, 'pairs', 'same.kept')
    assert (spread.runs, spread.mean) == (2, pytest.approx(0.9))
    assert spread.deviation == pytest.approx(0.1414, abs=1e-4)
    assert spread_of(runs, 'pairs', 'different.kept') is None
    assert str(spread_of(runs[:2], 'pairs', 'same.kept')) == '0.800 (1)'
    assert 'same.kept  0.900 ± 0.141 (2)' in spread_table(runs, 'pairs')


def test_command_of_a_run_repeats_it(tmp_path):
    figures, _ = measured('pairs', None, tmp_path / 'runs.json', lambda seeds: Figures(
        'pairs', 'mctrack reproduce pairs', {}, {'same.kept': seeds[0]}
    ))  # fmt: skip
    assert figures.command == 'mctrack reproduce pairs --seeds 1001-1005'
    assert figures.protocol['definition'] == definition_of('pairs')


@pytest.mark.parametrize('seeds', [(7,), (1001, 1002, 1003), (1, 5, 2)])
def test_listed_seeds_are_read_again(seeds):
    assert numbers(listed(seeds)) == seeds


@pytest.mark.parametrize(
    ('text', 'found'), [('1-3', (1, 2, 3)), ('7', (7,)), ('1,4-5', (1, 4, 5))]
)
def test_numbers_are_listed_singly_or_in_ranges(text, found):
    assert numbers(text) == found


@pytest.mark.parametrize('text', ['', '1-', '3,x', '-2', '1.5', '5-3'])
def test_what_lists_no_numbers_is_refused(text):
    with pytest.raises(ValueError, match='lists no numbers'):
        numbers(text)
