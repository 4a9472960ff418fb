import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.recording.tables import box_files, track_table

DOCS = Path(__file__).resolve().parents[1] / 'docs'


def documented_columns(page):
    rows = re.findall(r'^\| ((?:or )?.*?`[a-z]\w*`.*?) \| (.*?) \| .* \|$', page, re.MULTILINE)
    names = re.findall(r'`([a-z0-9_]+)`', ' '.join(cell for row in rows for cell in row[:2]))
    return set(names)


@pytest.mark.parametrize(
    ('name', 'columns'),
    [('own_detections.md', box_files.COLUMNS), ('evaluating.md', track_table.COLUMNS)],
)
def test_every_column_is_documented_and_every_documented_one_is_read(name, columns):
    documented = documented_columns((DOCS / name).read_text())
    known = {one for column, more in columns.items() for one in (column, *more)}
    assert documented <= known
    assert set(columns) <= documented


def test_the_documented_lines_of_the_detector_node_are_those_of_its_file():
    page, node = (DOCS / 'own_detections.md').read_text(), (DOCS / 'detector_node.py').read_text()
    lines = re.search(r'```python\n(.*?)```', page, re.DOTALL)[1].splitlines()
    assert len(lines) == 4
    assert all(f'    {line}\n' in node for line in lines)


def test_the_documented_reader_reads_a_cloud():
    spec = importlib.util.spec_from_file_location('read_cloud', DOCS / 'read_cloud.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    tracks = Tracks.build(1, position=[[1, 2, 0], [3, 4, 0]], track_id=[7, 8], velocity=np.eye(2))
    fields = module.fields(cloud_from_rows(tracks, ROSBAGS_CLASSES, 'map'))
    assert fields['track_id'].tolist() == [7, 8]
    assert fields['x'].tolist() == [1.0, 3.0]
    assert fields['velocity'].tolist() == [[1.0, 0.0], [0.0, 1.0]]
