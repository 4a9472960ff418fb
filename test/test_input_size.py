"""What comes from elsewhere is refused when it is larger than any that is meant."""

import os
from types import SimpleNamespace

import pytest

from mctrack_ros.codec import CodecError, cloud_from_rows, rows_from_cloud
from mctrack_ros.codec.clouds import MOST_ROWS
from mctrack_ros.config import ConfigError
from mctrack_ros.ground import CalibrationError, read_calibration, read_grid
from mctrack_ros.ground.yaml_files import read_yaml_file
from mctrack_ros.input_size import IMAGE, SETTINGS, SITE, TABLE
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import ROSBAGS_CLASSES, MotTextError
from mctrack_ros.recording.bags import mcap_scan
from mctrack_ros.recording.tables.columns import TableError, read_lines
from mctrack_ros.recording.tracks.mot_text import read_mot_text
from mctrack_ros.recording.tracks.moving_features import read_moving_features
from mctrack_ros.recording.tracks.tracab import _metadata
from mctrack_ros.recording.tracks.xml import read_xml
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.streams.credentials import user_and_password
from mctrack_ros.streams.frames import About


@pytest.mark.parametrize(
    ('read', 'most', 'error'),
    [
        (lambda path: read_yaml_file(path, ConfigError), SETTINGS, ConfigError),
        (read_grid, SETTINGS, CalibrationError),
        (lambda path: read_calibration(path, (64, 48)), SETTINGS, CalibrationError),
        (lambda path: CameraSettings(mask=path).ignore_mask(), IMAGE, ConfigError),
        (read_xml, SETTINGS, TableError),
        (_metadata, SETTINGS, TableError),
        (read_lines, TABLE, TableError),
        (lambda path: read_moving_features(path, None), TABLE, TableError),
        (lambda path: read_mot_text(path, 1), TABLE, MotTextError),
        (lambda path: user_and_password('MQTT', path), 4096, ConfigError),
    ],
)
def test_a_file_that_is_too_large_is_not_read(tmp_path, read, most, error):
    path = tmp_path / 'large.file'
    path.touch()
    os.truncate(path, most + 1)
    with pytest.raises(error) as raised:
        read(path if read in (read_xml, _metadata) else str(path))
    assert str(raised.value) == f'{path} holds {most + 1} bytes, expected at most {most}'


def test_a_cloud_of_too_many_rows_is_refused():
    cloud = cloud_from_rows(Detections.build(1), ROSBAGS_CLASSES, 'map')
    named = ('header', 'fields', 'is_bigendian', 'point_step', 'is_dense', 'data')
    wide = SimpleNamespace(**{name: getattr(cloud, name) for name in named})
    wide.height, wide.width = 2, MOST_ROWS
    with pytest.raises(CodecError, match=f'{2 * MOST_ROWS} Detections, expected at most'):
        rows_from_cloud(wide, Detections)


@pytest.mark.parametrize('method', ['zstd', 'lz4'])
def test_a_chunk_that_unpacks_into_far_too_much_is_not_unpacked(monkeypatch, method):
    import lz4.frame

    pack = {'zstd': mcap_scan.zstd.compress, 'lz4': lz4.frame.compress}[method]
    packed = pack(bytes(5_000_000))
    assert len(mcap_scan._unpacked(packed, method)) == 5_000_000
    monkeypatch.setattr(mcap_scan, '_LARGEST_CHUNK', 10_000)
    assert len(mcap_scan._unpacked(packed, method)) == 10_001


def test_a_description_of_a_site_that_is_too_long_is_refused():
    with pytest.raises(ValueError, match='expected at most'):
        About.of_site(' ' * (SITE + 1), 'map')
