"""The video node: a file's images, once or again and again."""

import subprocess
import threading
import time
from base64 import b64encode
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import quote

import cv2
import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Log
from sensor_msgs.msg import CompressedImage, Image

from films import level_image, write_film, write_steady_film
from mctrack_ros.codec import image_from_message, jpeg_from_image, stamp_ns_of
from mctrack_ros.recording.video.videos import open_video
from mctrack_ros.ros.nodes.video_node import VideoNode
from mctrack_ros.ros.topics.quality import reliable
from walker import SIZE

pytestmark = pytest.mark.live
USER, PASSWORD = 'some@body', 'for/the test'
RTSP_CAMERA = Path(__file__).resolve().parents[2] / 'rtsp_camera.py'
SYSTEM_PYTHON = '/usr/bin/python3'
GSTREAMER = "import gi; gi.require_version('GstRtspServer', '1.0')"


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


def test_a_stopped_node_waits_and_then_plays_from_the_beginning(bench, film):
    node, images = show(bench, film, loop=True)
    bench.until(lambda: len(images) > 5)
    node.trigger_deactivate()
    assert not node.finished
    images.clear()
    node.trigger_activate()
    bench.until(lambda: images)
    assert image_from_message(images[0]).mean() < 25  # the darkest
    node.trigger_deactivate()
    assert not node.finished
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


def test_no_log_shows_the_password_of_a_stream(bench, tmp_path):
    kept = tmp_path / 'camera.txt'
    kept.write_text(f'{USER}\n{PASSWORD}\n')
    node, _ = show(bench, 'rtsp://127.0.0.1:9/stream', credentials_file=str(kept))
    heard = bench.messages(Log, '/rosout', reliable(100))
    told = bench.messages(DiagnosticArray, '/diagnostics', reliable(100))
    bench.until(lambda: len([each for each in heard if 'cannot be opened' in each.msg]) > 1)
    bench.until(lambda: any('cannot be opened' in str(each) for each in told))
    node.trigger_deactivate()
    lines = [str(each) for each in (*heard, *told)]
    assert not [line for line in lines if PASSWORD in line or quote(PASSWORD) in line]


def test_an_address_with_a_password_is_refused(refusal):
    lines = refusal('video_node', source=f'rtsp://{USER}:{PASSWORD}@127.0.0.1:9/stream')
    assert 'put them into credentials_file' in lines[-1]
    assert not [line for line in lines if PASSWORD in line or quote(PASSWORD) in line]


@pytest.mark.parametrize('place', ['file', 'environment'])
def test_a_stream_is_given_user_and_password(bench, server, tmp_path, monkeypatch, place):
    told = {'source': server.address}
    if place == 'file':
        kept = tmp_path / 'camera.txt'
        kept.write_text(f'{USER}\n{PASSWORD}\n')
        told['credentials_file'] = str(kept)
    else:
        monkeypatch.setenv('MCTRACK_VIDEO_USERNAME', USER)
        monkeypatch.setenv('MCTRACK_VIDEO_PASSWORD', PASSWORD)
    server.wanted = 'Basic ' + b64encode(f'{USER}:{PASSWORD}'.encode()).decode()
    node, images = show(bench, depth=200, film=told.pop('source'), **told)
    bench.until(lambda: len(images) > 5)
    node.trigger_deactivate()


@pytest.fixture
def rtsp_camera():
    """Return a function that starts an RTSP camera at a port, and gives process and port."""
    found = subprocess.run([SYSTEM_PYTHON, '-c', GSTREAMER], capture_output=True, check=False)
    if found.returncode:
        pytest.skip('no RTSP server: GStreamer and its bindings for the system Python are missing')
    started = []

    def start(port=0):
        command = [SYSTEM_PYTHON, str(RTSP_CAMERA), str(port), USER, PASSWORD]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={})
        started.append(process)
        return process, int(process.stdout.readline())

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


def test_an_rtsp_camera_shows_its_images_to_who_knows_the_password_and_may_restart(
    bench, rtsp_camera, tmp_path
):
    camera, port = rtsp_camera()
    address = f'rtsp://127.0.0.1:{port}/stream'
    kept = tmp_path / 'camera.txt'
    kept.write_text(f'{USER}\n{PASSWORD}\n')
    node, images = show(bench, address, depth=200, credentials_file=str(kept))
    bench.until(lambda: len(images) > 20)
    assert image_from_message(images[0]).shape == (240, 320, 3)
    camera.kill()
    camera.wait()
    bench.until(lambda: node.health.live.failure)
    count = len(images)
    rtsp_camera(port)
    bench.until(lambda: len(images) > count + 5)
    assert node.health.live.opened == 2
    node.trigger_deactivate()


def test_an_rtsp_camera_shows_nothing_without_its_password(bench, rtsp_camera):
    _, port = rtsp_camera()
    node, images = show(bench, f'rtsp://127.0.0.1:{port}/stream')
    bench.until(lambda: 'cannot be opened' in node.health.live.failure)
    assert not images
    node.trigger_deactivate()


def test_a_stream_that_breaks_off_is_opened_again(bench, server):
    node, images = show(bench, server.address, depth=200)
    told = bench.messages(DiagnosticArray, '/diagnostics', reliable(100))
    bench.until(lambda: len(images) > 45)  # the server ends after 20
    assert not node.finished
    bench.until(lambda: node.health.live.opened > 2)
    node.trigger_deactivate()
    stamps = [stamp_ns_of(image) for image in images]
    assert stamps == sorted(set(stamps))
    states = [each for array in told for each in array.status if 'source' in each.name]
    assert states[0].hardware_id == '/cam1'
    assert any(int(value.value) > 0 for each in states for value in each.values)


def test_a_folder_of_images_has_the_times_of_its_names(bench, tmp_path):
    for index, time_ns in enumerate((5_000_000_000, 5_040_000_000, 5_120_000_000)):
        level = level_image(index, SIZE)
        cv2.imwrite(str(tmp_path / f'{1_700_000_000_000_000_000 + time_ns}.png'), level)
    node, images = show(bench, tmp_path, start=1000.0, realtime=False)
    bench.until(lambda: node.finished and len(images) == 3)
    stamps = [stamp_ns_of(image) * 1e-9 - 1000.0 for image in images]
    assert stamps == pytest.approx([0.0, 0.04, 0.12], abs=1e-6)


class Server(ThreadingHTTPServer):
    """Serves a film of 20 images as motion JPEG, at 50 Hz; asks for a user if one is wanted."""

    daemon_threads = True
    wanted = ''

    def __init__(self, film):
        super().__init__(('127.0.0.1', 0), Answer)
        self.parts = [jpeg_from_image(image).tobytes() for image in open_video(film).images()]
        self.address = f'http://127.0.0.1:{self.server_port}/film.mjpg'


class Answer(BaseHTTPRequestHandler):
    def do_GET(self):
        if self.server.wanted not in ('', self.headers['Authorization']):
            self.send_response(401)
            self.send_header('WWW-Authenticate', 'Basic realm="camera"')
            self.end_headers()
            return
        self.send_response(200)
        self.send_header('Content-Type', 'multipart/x-mixed-replace; boundary=part')
        self.end_headers()
        with suppress(OSError):
            for part in self.server.parts:
                head = f'--part\r\nContent-Type: image/jpeg\r\nContent-Length: {len(part)}'
                self.wfile.write(head.encode() + b'\r\n\r\n' + part + b'\r\n')
                time.sleep(0.02)

    def log_message(self, *_):
        """Say nothing."""


@pytest.fixture
def server(film):
    with Server(film) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()
