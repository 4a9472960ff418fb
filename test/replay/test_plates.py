"""Backgrounds of whole recordings, and the command that writes them."""

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

import mctrack_ros.replay.camera_source as plates
from drawn_hall import PERIOD_NS, SIZE, VIEWS, image, projection, walkers
from mctrack_ros.cli.main import app
from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception.background.plate import spread_median
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.replay.lockstep import camera_tasks
from mctrack_ros.replay.track import Source, track_bag
from mctrack_ros.site.site import load_site

SECONDS, RATE_HZ = 14, 4


@pytest.fixture(scope='module')
def hall(tmp_path_factory):
    """A bag of a hall in which people walk about from the first image to the last."""
    folder = tmp_path_factory.mktemp('hall')
    matrix = projection(VIEWS['north'])
    (folder / 'north.yaml').write_text(f'image_from_world: {matrix.tolist()}')
    size = f'image_width: {SIZE[0]}, image_height: {SIZE[1]}'
    (folder / 'site.yaml').write_text(
        f'name: hall\ncameras: {{north: {{calibration: north.yaml, {size}}}}}\n'
    )
    mapping, rng = ProjectiveMapping(matrix, SIZE), np.random.default_rng(3)
    with BagWriter(folder / 'bag') as writer:
        for index in range(SECONDS * RATE_HZ):
            stamp_ns = 10**12 + index * 10**9 // RATE_HZ + PERIOD_NS
            drawn = image(mapping, walkers(index / RATE_HZ), rng)
            message = compressed_message(
                jpeg_from_image(drawn), ROSBAGS_CLASSES, stamp_ns, 'north_optical_frame'
            )
            writer.write('/north/image_raw/compressed', message, stamp_ns)
    return folder


def north(hall):
    return camera_tasks(hall / 'bag', load_site(hall / 'site.yaml'))[0]


def test_median_agrees_with_numpy():
    images = np.random.default_rng(0).integers(0, 256, (11, 37, 20, 3), np.uint8)
    assert np.array_equal(spread_median(list(images)), np.median(images, axis=0))


def test_no_image_need_be_empty(hall):
    plate = plates.plate_of(north(hall))
    assert plate.shape == (SIZE[1], SIZE[0], 3)
    assert np.abs(plate.astype(int) - 110).max() < 12


def test_a_recording_of_few_images_has_none(hall, monkeypatch):
    monkeypatch.setattr(plates, 'LEAST_IMAGES', 1000)
    assert plates.plate_of(north(hall)) is None


def test_without_a_first_pass_nobody_is_seen_at_first_and_that_is_said(hall, tmp_path):
    site = load_site(hall / 'site.yaml')
    with_it, without = (
        track_bag(Source(hall / 'bag', first_pass=first_pass), tmp_path / str(first_pass), site)
        for first_pass in (True, False)
    )
    assert with_it.cameras['north.unsettled'] == 0
    assert without.cameras['north.unsettled'] >= 2
    assert without.cameras['north.detections'] < with_it.cameras['north.detections']
    assert any('could be compared with no background' in note for note in without.notes)


def run(hall, *more):
    words = ['background', str(hall / 'bag'), '--site', str(hall / 'site.yaml')]
    return CliRunner().invoke(app, [*words, *more])


def test_command_writes_an_image_a_camera_and_says_what_to_do(hall, tmp_path):
    result = run(hall, '--out', str(tmp_path / 'plates'))
    assert result.exit_code == 0, result.output
    assert 'north: background:' in result.output
    written = cv2.imread(str(tmp_path / 'plates/north.png'))
    assert np.array_equal(written, plates.plate_of(north(hall)))
    again = run(hall, '--out', str(tmp_path / 'plates'))
    assert 'give --overwrite' in str(again.exception)
    assert run(hall, '--out', str(tmp_path / 'plates'), '--overwrite').exit_code == 0


def test_command_refuses_a_recording_that_is_too_short(hall, tmp_path, monkeypatch):
    monkeypatch.setattr(plates, 'LEAST_IMAGES', 1000)
    result = run(hall, '--out', str(tmp_path / 'plates'))
    assert 'record longer' in str(result.exception)
    assert not (tmp_path / 'plates/north.png').exists()
