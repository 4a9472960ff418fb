import pytest
from typer.testing import CliRunner

from mctrack_experiments.cli.bench import app, numbers


@pytest.mark.parametrize('part', ['ground', 'watchdog', 'camera', 'fusion'])
def test_every_part_explains_itself(part):
    result = CliRunner().invoke(app, [part, '--help'])
    assert result.exit_code == 0
    assert '--json' in result.output


@pytest.mark.parametrize(
    ('text', 'listed'), [('1-3', (1, 2, 3)), ('7', (7,)), ('1,4-5', (1, 4, 5))]
)
def test_numbers_are_listed_singly_or_in_ranges(text, listed):
    assert numbers(text) == listed


@pytest.mark.parametrize('text', ['', '1-', '3,x', '-2', '1.5', '5-3'])
def test_what_lists_no_numbers_is_refused(text):
    with pytest.raises(ValueError, match='lists no numbers'):
        numbers(text)


def test_fusion_without_the_benchmark_names_its_folder(tmp_path):
    result = CliRunner().invoke(app, ['fusion', '--alone', '--folder', str(tmp_path)])
    assert isinstance(result.exception, OSError)
    assert str(tmp_path) in str(result.exception)
