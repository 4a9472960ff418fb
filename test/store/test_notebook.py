"""The notebook answers, its code cells run as they stand."""

import json
from pathlib import Path

import numpy as np

from mctrack_ros.interfaces import Tracks
from mctrack_ros.store import Database, NewRun, TrajectoryWriter

NOTEBOOK = Path(__file__).resolve().parents[2] / 'docs' / 'examples' / 'near_player.ipynb'
BEGAN_NS = 1_700_000_000_000_000_000


def test_the_notebook_says_who_was_near_player_7(tmp_path, monkeypatch, capsys):
    cells = json.loads(NOTEBOOK.read_text())['cells']
    code = [''.join(cell['source']) for cell in cells if cell['cell_type'] == 'code']
    assert sum(len(text.splitlines()) for text in code) <= 10
    path = tmp_path / 'out' / 'demo' / 'tracks.db'
    path.parent.mkdir(parents=True)
    with (
        Database(path, create=True) as database,
        TrajectoryWriter(database, NewRun('r')) as writer,
    ):
        for k in range(480):
            away = 1.5 + abs(k * 0.25 - 90) * 0.1
            position = np.array([[k * 0.25, 0, 0], [k * 0.25, away, 0], [0, 40, 0]])
            stamp_ns = BEGAN_NS + k * 250_000_000
            writer.write_tracks(Tracks.build(stamp_ns, track_id=[7, 8, 9], position=position))
    monkeypatch.chdir(tmp_path)
    names = {}
    for text in code:
        exec(text, names)
    said = capsys.readouterr().out.splitlines()
    assert said == ['8: 1.50 m at 90.0 s', 'player 7 went 120 m, at most 1.0 m/s']
