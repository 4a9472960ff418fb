import json

from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import write_mot_text


def mctrack(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_evaluate_prints_a_table_and_writes_figures(tmp_path):
    for name, error_m in (('truth.txt', 0.0), ('tracks.txt', 0.25)):
        instants = [
            Tracks.build(k * 40_000_000, track_id=[1], position=[[k + error_m, 0, 0]])
            for k in range(10)
        ]
        write_mot_text(tmp_path / name, instants, 40_000_000)
    output = mctrack(
        *('evaluate', tmp_path / 'truth.txt', tmp_path / 'tracks.txt', '--gate', 0.5),
        *('--json', tmp_path / 'scores.json'),
    )
    assert 'gate_m: 0.5' in output
    figures = json.loads((tmp_path / 'scores.json').read_text())['figures']
    assert (figures['mota'], figures['mean_distance']) == (1.0, 0.25)


def test_results_makes_the_page(tmp_path):
    Figures('cmc', 'mctrack reproduce cmc', {}, {'cmc1.mota': 0.999}).write(tmp_path / 'cmc.json')
    mctrack('results', '--folder', tmp_path, '--page', tmp_path / 'page.md')
    assert '| CMC1, MOTA at 1 m | 0.999 |  | ≥ 0.995 | yes |' in (tmp_path / 'page.md').read_text()
