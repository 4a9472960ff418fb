import json
import os

import pytest
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.recording import BagReader
from mctrack_ros.store import Database, Run, summaries, write_bag


def mctrack(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.xdist_group('replay')
def test_offline_demo_leaves_a_folder_of_results(rendering_here, tmp_path):
    out, copy = tmp_path / 'demo', tmp_path / 'copy.json'
    output = mctrack(
        *('demo', '--offline', '--seconds', 2, '--cameras', 2, '--out', out, '--json', copy)
    )
    assert (out / 'report.html').as_uri() in output
    content = json.loads(copy.read_text())
    assert content == json.loads((out / 'summary.json').read_text())
    assert content['command'] == 'mctrack demo --seconds 2 --cameras 2 --offline'
    assert content['figures']['ticks'] == 50
    assert content['figures']['latency_p50_ms'] is None
    names = {path.name for path in out.iterdir()}
    with Run(out / 'tracks.db') as run:
        assert summaries(run)
    with BagReader(out / 'source') as bag:
        images = [topic for topic in bag.topics if topic.endswith('compressed')]
    assert sorted(images) == [f'/cam{number}/image_raw/compressed' for number in (1, 2)]
    assert {'source', 'bag', 'report.html', 'birdseye.webm', 'tracks.txt', 'truth.txt'} <= names


@pytest.mark.live
@pytest.mark.xdist_group('live')
def test_live_demo_records_what_the_graph_says(tmp_path):
    mctrack(
        *(
            'demo',
            '--seconds',
            3,
            '--cameras',
            2,
            '--out',
            tmp_path,
            '--domain',
            40 + os.getpid() % 60,
        )
    )
    figures = json.loads((tmp_path / 'summary.json').read_text())['figures']
    assert figures['ticks'] >= 70
    assert figures['latency_p50_ms'] > 0
    with BagReader(tmp_path / 'bag') as bag:
        assert {'/tracks', '/ticks', '/feedback', '/site', '/truth/tracks'} <= bag.topics.keys()
        assert {'/cam1/detections', '/cam2/detections'} <= bag.topics.keys()
    assert 'real-time factor' in (tmp_path / 'graph.log').read_text()
    with BagReader(tmp_path / 'bag') as bag, Database(tmp_path / 'tracks.db') as database:
        ticks = bag.count('/tracks')
        write_bag(database, tmp_path / 'again')
    with BagReader(tmp_path / 'again') as again:
        assert again.count('/tracks') == ticks
