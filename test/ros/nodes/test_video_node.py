"""The video node: a file's images, once or again and again."""

from urllib.parse import quote

import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image

from films import level_image, write_film, write_steady_film
from mctrack_ros.codec import image_from_message, stamp_ns_of
from mctrack_ros.ros.nodes.video_node import VideoNode
from mctrack_ros.ros.topics.quality import reliable
from walker import SIZE

pytestmark = pytest.mark.live
USER, PASSWORD = 'some@body', 'for/the test'


@pytest.fixture
def film(tmp_path):
    """Return a video file of 20 ever brighter images at 50 Hz."""
    return write_steady_film(tmp_path / 'film.avi', 20, 50.0, SIZE)


def show(bench, film, kind=CompressedImage, **parameters):
    path = bench.parameter_file('video', {'source': str(film), **parameters})
    bench.open('--params-file', str(path))
    topic = '/cam1/' + parameters.get('image_topic', 'image_raw/compressed')
    images = bench.messages(kind, topic, reliable(200))
    return bench.add(VideoNode()), images


def test_a_file_is_played_to_its_end_at_its_rate(bench, film):
    node, images = show(bench, film)
    bench.until(lambda: node.finished and len(images) == 20)
    steps = np.diff([stamp_ns_of(image) for image in images])
    assert set(steps.tolist()) == {20_000_000}
    levels = [float(image_from_message(image).mean()) for image in images]
    assert levels == sorted(levels)
    assert not node.failure


def test_a_file_whose_rate_changes_keeps_its_times(bench, tmp_path):
    times = [3.0, 3.04, 3.08, 3.16, 3.24, 3.32, 3.36]
    images = [level_image(index, SIZE) for index in range(len(times))]
    film = write_film(tmp_path / 'film.mp4', times, images)
    node, shown = show(bench, film, start=1000.0, realtime=False)
    bench.until(lambda: node.finished and len(shown) == len(times))
    stamps = [stamp_ns_of(image) * 1e-9 - 1000.0 for image in shown]
    assert stamps == pytest.approx(np.array(times) - 3.0, abs=1e-3)


def test_a_file_without_times_asks_for_a_rate(bench, refusal, tmp_path):
    film = write_film(tmp_path / 'film.h264', [index / 25 for index in range(20)])
    line = refusal('video_node', source=str(film))[-1]
    assert 'does not say when its images were taken' in line
    node, shown = show(bench, film, rate=50.0, realtime=False)
    bench.until(lambda: node.finished and len(shown) == 20)
    steps = np.diff([stamp_ns_of(image) for image in shown])
    assert set(steps.tolist()) == {20_000_000}


def test_a_file_is_repeated_with_rising_stamps(bench, film):
    node, images = show(bench, film, loop=True, realtime=False, rate=100.0, depth=100)
    bench.until(lambda: len(images) >= 45)
    node.trigger_deactivate()
    stamps = [stamp_ns_of(image) for image in images]
    assert stamps == sorted(set(stamps))


def test_raw_and_scaled_images(bench, film):
    node, images = show(
        bench, film, Image, image_topic='image_raw', width=96, height=72, realtime=False
    )
    bench.until(lambda: node.finished and images)
    assert (images[0].width, images[0].height) == (96, 72)
    assert images[0].header.frame_id == 'cam1_optical_frame'


def test_no_log_shows_the_password_of_a_stream(refusal, tmp_path):
    kept = tmp_path / 'camera.txt'
    kept.write_text(f'{USER}\n{PASSWORD}\n')
    told = {'source': 'rtsp://127.0.0.1:9/stream', 'credentials_file': str(kept)}
    lines = refusal('video_node', **told)
    assert lines[-1].endswith('source rtsp://127.0.0.1:9/stream cannot be opened as a video')
    lines += refusal('video_node', source=f'rtsp://{USER}:{PASSWORD}@127.0.0.1:9/stream')
    assert 'put them into credentials_file' in lines[-1]
    assert not [line for line in lines if PASSWORD in line or quote(PASSWORD) in line]


def test_a_stream_is_given_user_and_password(bench, film, monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(VideoNode, 'opened', lambda node: asked.append(node.address))
    kept = tmp_path / 'camera.txt'
    kept.write_text(f'{USER}\n{PASSWORD}\n')
    source = {'source': 'rtsp://192.0.2.7/a@b', 'credentials_file': str(kept)}
    path = bench.parameter_file('video', {'autostart': False, **source})
    bench.open('--params-file', str(path))
    bench.add(VideoNode()).trigger_configure()
    assert asked == ['rtsp://some%40body:for%2Fthe%20test@192.0.2.7/a@b']


def test_a_stream_that_falls_silent_is_opened_again(bench, film):
    node, images = show(bench, f'file://{film}', depth=200)
    bench.until(lambda: len(images) > 25)
    assert not node.finished
    node.trigger_deactivate()
    stamps = [stamp_ns_of(image) for image in images]
    assert stamps == sorted(stamps)
