import pytest
from typer.testing import CliRunner

from mctrack_experiments.cli.bench import app


@pytest.mark.parametrize('part', ['ground', 'camera-shift', 'camera', 'store', 'fusion'])
def test_every_part_explains_itself(part):
    result = CliRunner().invoke(app, [part, '--help'])
    assert result.exit_code == 0
    assert '--json' in result.output


def test_fusion_without_the_benchmark_names_its_folder(tmp_path):
    result = CliRunner().invoke(app, ['fusion', '--alone', '--folder', str(tmp_path)])
    assert isinstance(result.exception, OSError)
    assert str(tmp_path) in str(result.exception)
