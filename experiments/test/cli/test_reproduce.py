import pytest
import typer
from typer.testing import CliRunner

from mctrack_experiments.cli.reproduce import reproduce
from mctrack_experiments.papers.event_tracking import pairs
from mctrack_experiments.runs import read_runs
from mctrack_ros.evaluation.figures import Figures

app = typer.Typer()
app.command()(reproduce)


@pytest.fixture
def measured(monkeypatch):
    """Return the seeds that were measured; the figure is the first of them."""
    measured = []

    def reproduce_pairs(seeds, progress):
        measured.append(seeds)
        return Figures('pairs', 'mctrack reproduce pairs', {}, {'same.kept': seeds[0] / 1e4})

    monkeypatch.setattr(pairs, 'reproduce_pairs', reproduce_pairs)
    return measured


def run(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def test_every_run_takes_fresh_seeds_and_is_kept(measured, tmp_path):
    kept = tmp_path / 'runs.json'
    run('pairs', '--runs', kept)
    result = run('pairs', '--runs', kept, '--json', tmp_path / 'pairs.json')
    assert [seeds[0] for seeds in measured] == [1001, 2001]
    assert [(one.number, one.seeds) for one in read_runs(kept)] == [
        (1, '1001-1005'),
        (2, '2001-2005'),
    ]
    assert 'same.kept  0.150 ± 0.071 (2)' in result.output
    written = Figures.read(tmp_path / 'pairs.json')
    assert written.command == 'mctrack reproduce pairs --seeds 2001-2005'


def test_a_run_is_repeated_by_its_seeds_and_not_counted_again(measured, tmp_path):
    kept = tmp_path / 'runs.json'
    run('pairs', '--runs', kept)
    run('pairs', '--runs', kept, '--seeds', '1001-1005')
    assert measured[0] == measured[1]
    assert len(read_runs(kept)) == 1


def test_without_a_place_to_keep_it_nothing_is_run(measured, tmp_path):
    result = run('pairs', '--runs', tmp_path / 'nowhere' / 'runs.json')
    assert isinstance(result.exception, OSError)
    assert '--seeds' in str(result.exception)
    assert not measured


def test_seeds_are_refused_where_there_are_none_to_choose():
    assert 'lab6p has no seeds' in str(run('lab6p', '--seeds', '1').exception)


def test_repeats_are_refused_where_one_run_says_it_all():
    assert 'lab6p has one run' in str(run('lab6p', '--repeat', '2').exception)
