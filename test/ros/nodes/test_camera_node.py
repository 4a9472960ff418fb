"""The camera node over DDS: images to detections, and what cannot stop it."""

import dataclasses
import time
from array import array

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.parameter import Parameter
from sensor_msgs.msg import CompressedImage, Image, PointCloud2

import moving_camera
from far_hall import write_far_hall
from mctrack_ros.codec import cloud_from_rows, compressed_message, image_message, jpeg_from_image
from mctrack_ros.ground import read_grid, write_grid
from mctrack_ros.interfaces import Detections, EventCode, Events, Feedback
from mctrack_ros.resources import config_file
from mctrack_ros.ros.node import silence
from mctrack_ros.ros.nodes.camera_node import CameraNode
from mctrack_ros.ros.topics.choice import are_images
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from walker import PERIOD_NS, SIZE, camera_parameters, walker_message

pytestmark = pytest.mark.live

START_NS = 1_700_000_000 * 10**9 + PERIOD_NS // 2


class Images:
    """What a camera would publish, and what its node makes of it."""

    def __init__(self, bench, kind=CompressedImage, topic='/cam1/image_raw/compressed'):
        self.bench = bench
        self.detections = bench.rows(Detections, '/cam1/detections')
        self.events = bench.rows(Events, '/cam1/events')
        self.images = bench.publisher(kind, topic)
        bench.heard('/cam1/detections')
        bench.heard('/cam1/events')

    def show(self, indices, start_ns=START_NS):
        """Send walker images, each processed before the next."""
        for index in indices:
            self.send(walker_message(index, start_ns + index * PERIOD_NS))

    def send(self, message):
        """Send an image that gives detections."""
        before = len(self.detections)
        self.images.publish(message)
        self.bench.until(lambda: len(self.detections) > before)

    def refused(self, message):
        """Send an image that is refused, and say how many were."""
        health = self.bench.nodes[0].health
        before = health.totals.get('refused', 0)
        self.images.publish(message)
        self.bench.until(lambda: health.totals.get('refused', 0) > before)


@pytest.fixture
def camera(bench, projection):
    bench.make(CameraNode, **camera_parameters(projection))
    return Images(bench)


def test_each_image_gives_detections_with_its_stamp(camera):
    camera.show(range(30))
    stamps = [detections.stamp_ns for detections in camera.detections]
    assert stamps == [START_NS + index * PERIOD_NS for index in range(30)]
    assert camera.detections[0].is_blind
    assert len(camera.detections[-1]) == 1
    assert not camera.detections[-1].is_blind


def test_a_clock_that_is_ahead_is_set_right_for_feedback_and_told_as_it_is(bench, projection):
    parameters = camera_parameters(projection)
    parameters['settings']['clock_offset'] = 0.12
    node, asked = bench.make(CameraNode, **parameters), []
    select = node.feedback.select
    node.feedback.select = lambda stamp_ns: asked.append(stamp_ns) or select(stamp_ns)
    camera = Images(bench)
    camera.show(range(2), START_NS + 120_000_000)
    assert asked == [START_NS, START_NS + PERIOD_NS]
    stamps = [detections.stamp_ns for detections in camera.detections]
    assert stamps == [stamp_ns + 120_000_000 for stamp_ns in asked]


def test_raw_images_are_taken_too(bench, projection):
    parameters = camera_parameters(projection)
    parameters['settings']['image_topic'] = 'image_raw'
    bench.make(CameraNode, **parameters)
    camera = Images(bench, Image, '/cam1/image_raw')
    blank = np.full((SIZE[1], SIZE[0], 3), 99, np.uint8)
    camera.send(image_message(blank, RCLPY_CLASSES, START_NS, 'cam1_optical_frame'))
    assert camera.detections[0].stamp_ns == START_NS


@pytest.mark.parametrize(
    ('scale', 'said'),
    [(1, 'calibration accepted at a first look'), (2, 'they fit images of 768 x 576 px')],
)
def test_the_node_says_at_its_start_whether_its_grid_is_to_be_trusted(
    bench, projection, tmp_path, capfd, scale, said
):
    grid = read_grid(config_file('pitch5/cam5.xml'))
    write_grid(dataclasses.replace(grid, image_size=None), tmp_path / 'grid.xml')
    parameters = camera_parameters(projection)
    parameters['settings'] |= {
        'calibration': '', 'grid': str(tmp_path / 'grid.xml'),
        'image_width': 768 * scale, 'image_height': 576 * scale,
    }  # fmt: skip
    bench.make(CameraNode, **parameters)
    assert said in capfd.readouterr().err


def test_a_node_says_once_which_images_it_waits_for(bench, projection, monkeypatch, capfd):
    monkeypatch.setattr(silence, 'PATIENCE_S', 0.1)
    bench.make(CameraNode, **camera_parameters(projection))
    said = []

    def warnings():
        said.extend(line for line in capfd.readouterr().err.splitlines() if 'waiting' in line)
        return said

    bench.until(warnings)
    end = time.monotonic() + 0.5
    bench.until(lambda: time.monotonic() > end)
    (line,) = warnings()
    assert 'waiting for /cam1/image_raw/compressed: nothing has come, nobody publishes it' in line


@pytest.mark.parametrize('name', ['1cam', 'a b', 'a/b'])
@pytest.mark.parametrize('node', ['camera_node', 'video_node', 'fusion_node'])
def test_a_name_that_is_no_cameras_is_refused_in_one_line(refusal, tmp_path, node, name):
    source = tmp_path / 'film.avi'
    given = {
        'camera_node': {'camera': name},
        'video_node': {'camera': name, 'source': str(source)},
        'fusion_node': {'cameras': ['cam1', name]},
    }
    source.touch()
    (line,) = refusal(node, **given[node])
    assert f"camera '{name}': expected letters, digits" in line


def test_a_camera_far_from_its_origin_ends_with_the_line_to_set(refusal, tmp_path):
    write_far_hall(tmp_path / 'far', (389000.0, 5820000.0))
    settings = {
        'grid': str(tmp_path / 'far' / 'north.xml'), 'image_width': 320, 'image_height': 240,
    }  # fmt: skip
    assert (
        'set origin: 389000,5820000'
        in refusal('camera_node', camera='north', settings=settings)[-1]
    )


def bad_images(stamp_ns):
    empty = walker_message(1, stamp_ns)
    empty.data = b''
    garbled = walker_message(1, stamp_ns)
    garbled.data = b'not an image'
    small = CompressedImage(header=empty.header, format='jpeg')
    small.data = jpeg_from_image(np.zeros((20, 30, 3), np.uint8)).tobytes()
    huge = CompressedImage(header=empty.header, format='jpeg')
    frame = small.data.tobytes().index(b'\xff\xc0')
    huge.data = small.data[: frame + 5] + array('B', b'\xff' * 4) + small.data[frame + 9 :]
    return {
        'empty': empty,
        'garbled': garbled,
        'of another size': small,
        'huge by its header': huge,
        'again': walker_message(2, START_NS + 2 * PERIOD_NS),
        'backwards': walker_message(1, START_NS + PERIOD_NS),
    }


def test_bad_images_are_refused_and_the_node_lives_on(camera):
    camera.show(range(3))
    for image in bad_images(START_NS + 3 * PERIOD_NS).values():
        camera.refused(image)
    camera.show(range(3, 5))
    assert len(camera.detections) == 5


def test_a_threshold_is_set_while_the_camera_sees_and_the_rest_is_refused(bench, camera):
    camera.show(range(20))
    assert len(camera.detections[-1])
    node = bench.nodes[0]
    name = 'settings.pipeline.background.minimum_threshold'
    assert node.set_parameters([Parameter(name, value=255.0)])[0].successful
    camera.show(range(20, 25))
    assert not len(camera.detections[-1])
    still = node.set_parameters([Parameter('settings.pipeline.background.still_s', value=1.0)])[0]
    assert 'takes effect on configuration' in still.reason


def test_stamps_that_step_far_back_begin_anew(camera):
    camera.show(range(3))
    camera.show(range(3), START_NS - 10**10)
    assert len(camera.detections) == 6


def missed_stamps(events):
    missed = EventCode.FEEDBACK_MISSED
    return [one.stamp_ns for one in events if missed in one.event.tolist()]


def test_missed_feedback_is_an_event(bench, camera):
    camera.show(range(20))
    bench.until(lambda: len(missed_stamps(camera.events)) == 18)
    assert missed_stamps(camera.events)[0] == START_NS + 2 * PERIOD_NS
    assert bench.nodes[0].health.totals['feedback missed'] == 18


def test_feedback_in_time_is_not_missed(bench, camera):
    feedback = bench.publisher(PointCloud2, '/feedback')
    for index in range(20):
        empty = Feedback.build(START_NS + index * PERIOD_NS)
        feedback.publish(cloud_from_rows(empty, RCLPY_CLASSES, 'map'))
        camera.show([index])
    assert 'feedback missed' not in bench.nodes[0].health.totals


def test_broken_feedback_is_refused(bench, camera):
    feedback = bench.publisher(PointCloud2, '/feedback')
    feedback.publish(cloud_from_rows(Detections.build(START_NS), RCLPY_CLASSES, 'map'))
    bench.until(lambda: bench.nodes[0].health.totals.get('refused') == 1)
    nowhere = Feedback.build(START_NS, position=[[3e38, 0, 0]], track_id=[1])
    feedback.publish(cloud_from_rows(nowhere, RCLPY_CLASSES, 'map'))
    bench.until(lambda: bench.nodes[0].health.totals.get('refused') == 2)
    camera.show([0])


def test_debug_image_is_drawn_while_somebody_looks(bench, camera):
    drawings = bench.messages(Image, '/cam1/debug_image')
    bench.heard('/cam1/debug_image')
    bench.until(lambda: bench.nodes[0].debug_image.get_subscription_count() == 1)
    camera.show(range(3))
    bench.until(lambda: drawings)
    assert (drawings[0].width, drawings[0].height) == SIZE


@pytest.mark.parametrize('private', [True, False])
def test_nobody_gets_a_picture_from_a_private_camera(bench, projection, private):
    bench.make(CameraNode, private=private, **camera_parameters(projection))
    camera = Images(bench)
    camera.show(range(2))
    bench.heard('/cam1/foreground/compressed')
    offered = dict(bench.observer.get_topic_names_and_types())
    pictures = {topic for topic, kinds in offered.items() if are_images(kinds)}
    kept = {'/cam1/image_raw/compressed', '/cam1/foreground/compressed'}
    assert pictures - kept == (set() if private else {'/cam1/debug_image'})


def test_a_camera_that_has_moved_is_a_warning_until_it_is_configured_anew(bench, projection):
    parameters = camera_parameters(projection)
    parameters['settings'] |= {'image_width': moving_camera.SIZE[0]}
    parameters['settings'] |= {'image_height': moving_camera.SIZE[1]}
    parameters['settings']['pipeline']['camera_shift'] = {'settling_s': 5.0}
    node = bench.make(CameraNode, **parameters)
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    camera, still = Images(bench), moving_camera.ground()

    def show(seconds, right):
        for index in range(*(round(5 * second) for second in seconds)):
            jpeg = jpeg_from_image(moving_camera.seen(still, right=right))
            stamp_ns = START_NS + index * 200_000_000
            camera.send(compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, 'cam1_optical_frame'))

    def said(message):
        reports.clear()
        bench.until(lambda: any(message in pose.message for pose in poses(reports)))
        return next(pose for pose in poses(reports) if message in pose.message)

    show((0, 10), 0.0)
    assert said('has not moved').level == DiagnosticStatus.OK
    show((10, 15), 6.0)
    pose = said('has moved')
    assert pose.level == DiagnosticStatus.WARN
    values = {value.key: value.value for value in pose.values}
    assert float(values['shift [px]']) == pytest.approx(6.0, abs=0.2)
    assert float(values['added noise [px]']) == pytest.approx(6.0, abs=0.2)
    for transition in (node.trigger_deactivate, node.trigger_cleanup, node.trigger_configure):
        transition()
    node.trigger_activate()
    bench.heard('/cam1/detections')
    bench.until(lambda: camera.images.get_subscription_count() > 0)
    show((15, 25), 6.0)
    assert said('has not moved').level == DiagnosticStatus.OK


def test_black_and_noisy_images_are_an_error_on_diagnostics_until_they_are_over(bench, camera):
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    rng = np.random.default_rng(2)

    def said(image, index):
        stamp_ns = START_NS + index * PERIOD_NS
        camera.send(
            compressed_message(
                jpeg_from_image(image), RCLPY_CLASSES, stamp_ns, 'cam1_optical_frame'
            )
        )
        reports.clear()
        bench.until(lambda: any('image' in one.name for r in reports for one in r.status))
        return next(one for r in reports for one in r.status if 'image' in one.name)

    camera.show(range(3))
    for index, image in enumerate(
        [np.zeros((*SIZE[::-1], 3), np.uint8), rng.integers(0, 256, (*SIZE[::-1], 3), np.uint8)]
    ):
        state = said(image, 3 + index)
        assert state.level == DiagnosticStatus.ERROR
        assert state.message.endswith(('black or white', 'noise'))
    camera.show(range(5, 35))  # the background is learned anew
    reports.clear()
    bench.until(
        lambda: any(one.message.endswith('show something') for r in reports for one in r.status)
    )


def poses(reports):
    """Return what was said about the camera's pose."""
    return [one for report in reports for one in report.status if 'calibration' in one.name]
