import importlib.util
from pathlib import Path

import numpy as np

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES

DOCS = Path(__file__).resolve().parents[1] / 'docs'


def test_the_documented_reader_reads_a_cloud():
    spec = importlib.util.spec_from_file_location('read_cloud', DOCS / 'read_cloud.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    tracks = Tracks.build(1, position=[[1, 2, 0], [3, 4, 0]], track_id=[7, 8], velocity=np.eye(2))
    fields = module.fields(cloud_from_rows(tracks, ROSBAGS_CLASSES, 'map'))
    assert fields['track_id'].tolist() == [7, 8]
    assert fields['x'].tolist() == [1.0, 3.0]
    assert fields['velocity'].tolist() == [[1.0, 0.0], [0.0, 1.0]]
