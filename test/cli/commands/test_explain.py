import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.cli.main import app
from mctrack_ros.config import ConfigError
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagWriter

ROOT = Path(__file__).parents[3]

SITE = """
name: hall
cameras:
  one: {}
  two: {}
"""


def mctrack(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture
def tracked(tmp_path):
    """Return the folder with detections of one who walks, their truth, and what was tracked."""
    (tmp_path / 'site.yaml').write_text(SITE)
    with BagWriter(tmp_path / 'seen') as bag:
        for index in range(40):
            stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
            place = [[0.03 * index, 0.0]]
            for camera in ('one', 'two'):
                bag.write_rows(f'/{camera}/detections', detections(stamp_ns, place), 'map')
            truth = Tracks.build(stamp_ns, position=[[*place[0], 0.0]], track_id=[1])
            bag.write_rows('/truth/tracks', truth, 'map')
    mctrack(
        'track', tmp_path / 'seen', '--out', tmp_path / 'out', '--site', tmp_path / 'site.yaml'
    )
    return tmp_path


def test_the_example_of_the_documentation_is_what_the_command_prints():
    page = (ROOT / 'docs' / 'how-to' / 'explain.md').read_text()
    command, shown = re.findall(r'```\n(.*?)```', page, re.DOTALL)[:2]
    words = [ROOT / word if word.startswith('bags/') else word for word in command.split()[1:]]
    printed = [line.rstrip() for line in mctrack(*words[: words.index('--out')]).splitlines()]
    missing = [line for line in shown.splitlines() if line and line.rstrip() not in printed]
    assert not missing


@pytest.mark.parametrize(
    ('wrong', 'said'),
    [
        (('--at', 'nan'), 'expected a number'),
        (('--at', 1, '--out', 'why.foo'), 'expected .png'),
        (('--at', 1, '--out', 'nowhere/why.png'), 'there is no folder'),
    ],
)
def test_what_cannot_be_is_refused_before_the_work(wrong, said):
    result = CliRunner().invoke(app, ['explain', 'bag', '--track', '1', *map(str, wrong)])
    assert result.exit_code == 2
    assert said in ' '.join(result.output.replace('│', ' ').split())


def test_a_site_with_other_cameras_than_the_bag_is_refused(tracked):
    (tracked / 'other.yaml').write_text('name: hall\ncameras:\n  one: {}\n  six: {}\n')
    words = ['explain', tracked / 'out' / 'bag', '--track', 1, '--at', 0.5]
    with pytest.raises(ConfigError, match='one, two; the site has one, six'):
        mctrack(*words, '--site', tracked / 'other.yaml')


def test_explain_says_that_nothing_changed(tracked):
    words = ('explain', tracked / 'out' / 'bag', '--track', 1, '--at', 1)
    assert 'Nothing changed for it until 1.200 s.' in mctrack(*words, '--for', 0.2)
    assert 'Nothing changed' not in mctrack(*words)


def test_explain_says_why_and_draws_it(tracked):
    output = mctrack(
        *('explain', tracked / 'out' / 'bag', '--track', 1, '--at', 0.5, '--for', 1),
        *('--out', tracked / 'why.png', '--json', tracked / 'why.json'),
    )
    assert output.startswith('Track 1 at 0.520 s') or output.startswith('Track 1 at 0.480 s')
    assert 'what became of it' in output
    assert 'taken' in output
    assert (tracked / 'why.png').stat().st_size > 10_000
    assert (tracked / 'why.json').exists()


def test_evaluate_lists_switches_and_how_to_ask_why(tracked):
    with BagWriter(tracked / 'switched') as bag:
        for index in range(40):
            stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
            place = [[0.03 * index, 0.0, 0.0]]
            bag.write_rows(
                '/tracks',
                Tracks.build(stamp_ns, position=place, track_id=[5 + index // 20]),
                'map',
            )
    output = mctrack('evaluate', tracked / 'seen', tracked / 'switched')
    bag = tracked / 'switched'
    assert output.splitlines()[-3:] == [
        '     0.80 s  1 was 5 (until 0.76 s), is 6, at (0.6, 0.0) m',
        f'             mctrack explain {bag} --track 5 --at 0.76 --for 0.04',
        f'             mctrack explain {bag} --track 6 --at 0.80',
    ]
    same = mctrack('evaluate', tracked / 'seen', tracked / 'out' / 'bag')
    assert 'identity switches' not in same


def test_switches_of_text_are_listed_without_a_bag_to_ask(tmp_path):
    rows = np.array([[frame, 1 + (frame > 5), 0, 0] for frame in range(1, 11)], float)
    for name, ids in (('truth.txt', np.ones(10)), ('tracks.txt', rows[:, 1])):
        lines = [f'{int(f)},{int(i)},-1,-1,-1,-1,1,0,0,0' for f, i in zip(rows[:, 0], ids)]
        (tmp_path / name).write_text('\n'.join(lines) + '\n')
    output = mctrack('evaluate', tmp_path / 'truth.txt', tmp_path / 'tracks.txt')
    assert output.splitlines()[-2:] == [
        'identity switches: true id, its old and its new track',
        '     0.20 s  1 was 1 (until 0.16 s), is 2, at (0.0, 0.0) m',
    ]
