"""One camera: images and feedback in, detections and events out."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from nav_msgs.msg import OccupancyGrid
from rclpy.lifecycle import LifecyclePublisher
from sensor_msgs.msg import CompressedImage, Image, PointCloud2

from mctrack_ros.codec import (
    image_from_message,
    image_message,
    ros_from_message,
    rows_from_cloud,
    stamp_ns_of,
)
from mctrack_ros.config import ConfigError, parameter, replace_parameters
from mctrack_ros.interfaces import Detections, Likelihood, Message, starts_anew
from mctrack_ros.perception import (
    CameraShift,
    ImageState,
    ImageWatch,
    ShiftState,
    camera_method,
    feedback_missed,
    open_buffer,
)
from mctrack_ros.perception.mosaic import without_faces
from mctrack_ros.perception.output import CameraOutput
from mctrack_ros.perception.overlay import Overlay
from mctrack_ros.ros.health.stream_health import DiagnosticsConfig
from mctrack_ros.ros.interop.boxes import BOXES
from mctrack_ros.ros.interop.camera_frames import CameraFrames
from mctrack_ros.ros.node.camera_health import ImageHealth, PoseHealth
from mctrack_ros.ros.node.diagnostics import Diagnostics, Health, stream_health
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.loops import compile_loops
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.node.silence import warn_of_silence
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES, message_class
from mctrack_ros.ros.topics.occupancy import likelihood_grid
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.names import check_camera_name, named_image_topic


@dataclass(frozen=True, slots=True)
class CameraNodeConfig:
    """Parameters of `camera_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    camera: str = parameter('cam1', 'name of the camera; its topics lie below it')
    ground_frame: str = parameter('map', 'frame_id of positions on the ground')
    period: float = parameter(0.04, "the fusion node's period [s]", minimum=0.001, maximum=10.0)
    feedback_delay: float = parameter(
        0.08, 'age of the feedback that an image uses; two periods [s]', minimum=0.0, maximum=10.0
    )
    reliable: bool = parameter(False, 'reliable transport: lost images are sent again')
    depth: int = parameter(
        2,
        'length of the queue of images; of more, the oldest are dropped',
        minimum=1,
        maximum=1000,
    )
    private: bool = parameter(
        False, 'publish no picture: no debug_image; masks of silhouettes go to who takes them'
    )
    blur: bool = parameter(True, 'make people in debug_image unrecognisable', at_run_time=True)
    frames: bool = parameter(
        True,
        "publish the camera's place on tf_static and its lens on camera_info, from the "
        "calibration; false where the camera's driver or a robot description does",
    )
    diagnostics: DiagnosticsConfig = DiagnosticsConfig()
    settings: CameraSettings = CameraSettings()


class CameraNode(GraphNode):
    """The workstation of the event-tracking paper, section 4.1, as a node."""

    CONFIG = CameraNodeConfig
    config: CameraNodeConfig

    def __init__(self) -> None:
        super().__init__('camera_node')

    def open(self) -> None:
        """Build the tracker and the publishers."""
        settings, camera = self.config.settings, self.config.camera
        check_camera_name(camera)
        self.tracker, self.overlay = settings.open(camera), Overlay()
        compile_loops('mctrack_ros.perception')
        self.method = camera_method(settings.pipeline)
        self.note_calibration()
        self.forget_feedback()
        self.last_stamp_ns = -1
        self.open_health()
        self.open_topics()

    def open_health(self) -> None:
        """Build what `/diagnostics` tells of."""
        camera = self.config.camera
        self.health = stream_health(self)
        self.pose = PoseHealth()
        self.watch, self.sight = ImageWatch(), ImageHealth()
        parts: dict[str, Health] = {
            camera: self.health,
            f'{camera} calibration': self.pose,
            f'{camera} image': self.sight,
        }
        self.diagnostics = Diagnostics(self, parts, (camera,))

    def open_topics(self) -> None:
        """Make the publishers."""
        camera, settings, reliable = self.config.camera, self.config.settings, quality.reliable
        self.messages = {
            kind.TOPIC: self.publisher(
                message_class(kind.ROS_TYPE), f'{camera}/{kind.TOPIC}', reliable(10)
            )
            for kind in self.method.messages
        }
        self.events = self.publisher(PointCloud2, f'{camera}/events', reliable(100))
        self.debug_image: LifecyclePublisher | None = None
        if not self.config.private:
            self.debug_image = self.publisher(Image, f'{camera}/debug_image', reliable(1))
        self.frames: CameraFrames | None = None
        if self.config.frames and not settings.pipeline.moves:
            frame, mapping = self.config.ground_frame, settings.mapping()
            self.frames = CameraFrames(self, camera, frame, mapping)
        self.likelihood_grid: LifecyclePublisher | None = None
        if Likelihood in self.method.messages:
            self.likelihood_grid = self.publisher(
                OccupancyGrid, f'{camera}/likelihood_grid', reliable(1)
            )

    def note_calibration(self) -> None:
        """Log whether the calibration is to be trusted."""
        settings = self.config.settings
        doubt = settings.doubt()
        if doubt:
            file = settings.grid or settings.calibration
            self.get_logger().warning(
                f'calibration doubtful: {file}: {doubt} (mctrack check-calibration)'
            )
        elif settings.grid:
            self.get_logger().info(f'calibration accepted at a first look: {settings.grid}')

    def forget_feedback(self) -> None:
        """Begin without feedback."""
        config = self.config
        period_ns, delay_ns = round(config.period * 1e9), round(config.feedback_delay * 1e9)
        self.feedback = open_buffer(config.settings.pipeline, period_ns, delay_ns)

    def start(self) -> None:
        """Subscribe."""
        topic = named_image_topic(self.config.camera, self.config.settings.image_topic)
        kind = CompressedImage if topic.endswith('/compressed') else Image
        feedback = self.method.feedback.TOPIC
        self.subscribe(PointCloud2, feedback, self.on_feedback, quality.reliable(10))
        images, received = quality.images(self.config.reliable, self.config.depth), self.on_image
        if self.config.settings.boxes_topic:
            topic, received = self.boxes_topic(), self.on_boxes
            name, self.detections_of = BOXES[self.config.settings.boxes_type]
            kind, self.mapping = message_class(name), self.config.settings.mapping()
        self.create_subscription(kind, topic, received, images)
        before_ns = self.health.last_stamp_ns
        warn_of_silence(self, topic, lambda: self.health.last_stamp_ns != before_ns)
        self.diagnostics.begin()
        if self.frames is not None:
            self.frames.publish()

    def on_feedback(self, message: PointCloud2) -> None:
        """Keep what the fusion node believes."""
        try:
            left_out = self.feedback.push(rows_from_cloud(message, self.method.feedback))
        except ValueError as error:
            self.refuse(f'feedback refused: {error}')
            return
        if left_out:
            self.refuse(f'{left_out} rows of feedback refused: no target can be so')

    def boxes_topic(self) -> str:
        """Return where boxes come from; refuse a tracker of fusion that needs more."""
        if self.method.messages[0] is not Detections:
            raise ConfigError(
                'boxes_topic gives detections alone: name local_tracker event_tracker'
            )
        return named_image_topic(self.config.camera, self.config.settings.boxes_topic)

    def on_boxes(self, message: Any) -> None:
        """Put the boxes of somebody else's detector on the ground."""
        stamp_ns = stamp_ns_of(message)
        self.health.arrived(stamp_ns, self.get_clock().now().nanoseconds)
        try:
            self.check_stamp(stamp_ns)
            detections = self.detections_of(message, self.mapping)
        except ValueError as error:
            self.refuse(f'boxes refused: {error}')
            return
        self.last_stamp_ns = stamp_ns
        self.send(self.messages[Detections.TOPIC], detections)
        self.health.published(stamp_ns, self.get_clock().now().nanoseconds)

    def on_image(self, message: Any) -> None:
        """Take one image through the tracker."""
        stamp_ns = stamp_ns_of(message)
        self.health.arrived(stamp_ns, self.get_clock().now().nanoseconds)
        try:
            self.check_stamp(stamp_ns)
            settings = self.config.settings
            size = (settings.image_width, settings.image_height)
            image = image_from_message(message, size)
        except ValueError as error:
            self.refuse(f'image refused: {error}')
            return
        self.last_stamp_ns = stamp_ns
        self.note_state(self.watch.look(image, stamp_ns))
        true_ns = stamp_ns - settings.ahead_ns  # fusion takes it from what is sent itself
        feedback, missed = self.feedback.select(true_ns)
        if missed:
            self.health.count('feedback missed')
            self.send(self.events, feedback_missed(stamp_ns))
        output = self.tracker.step(image, true_ns, feedback)
        self.publish_output(output, stamp_ns)
        self.note_shift(output.shift)
        self.note_settled(output.is_settled)
        self.show(image, output)

    def publish_output(self, output: CameraOutput, stamp_ns: int) -> None:
        """Publish what an image, of a stamp by the camera's own clock, gave."""
        if len(output.events):
            self.send(self.events, output.events.at(stamp_ns))
        for topic, message in output.messages.items():
            self.send(self.messages[topic], message.at(stamp_ns))
        self.health.published(stamp_ns, self.get_clock().now().nanoseconds)

    def changed(self, names: set[str], before: CameraNodeConfig) -> None:
        """See by other thresholds from now on."""
        if self.config.settings != before.settings:
            pipelines = before.settings.pipeline, self.config.settings.pipeline
            replace_parameters(self.tracker, *pipelines)

    def note_state(self, state: ImageState) -> None:
        """Keep whether images show anything; log when that changes."""
        before, self.sight.state = self.sight.state, state
        if state is not before and state is not ImageState.USABLE:
            self.get_logger().warning(f'the images cannot be used: {state}')
        elif state is not before:
            self.get_logger().info('the images can be used again')

    def note_settled(self, is_settled: bool) -> None:
        """Keep whether there is a background; log when one is learned anew, and when it is."""
        before, self.sight.is_settled = self.sight.is_settled, is_settled
        if is_settled and not before:
            self.get_logger().info('the background is learned')
        elif before and not is_settled:
            self.get_logger().warning('the background is learned: nobody is seen meanwhile')

    def note_shift(self, shift: CameraShift) -> None:
        """Keep how far the camera has moved; log when the camera moves or is back."""
        before, self.pose.shift = self.pose.shift.state, shift
        if shift.state is before:
            return
        if shift.state is ShiftState.MOVED:
            self.get_logger().warning(
                f'the camera has moved by {shift.size_px:.1f} px: calibrate it anew'
            )
        elif before is ShiftState.MOVED:
            self.get_logger().info('the camera is back where it was')

    def show(self, image: Any, output: CameraOutput) -> None:
        """Publish the image with detections drawn in, and the likelihoods, for subscribers."""
        self.show_likelihood(output)
        if self.debug_image is None or not self.debug_image.get_subscription_count():
            return
        groups, predicted = self.tracker.groups(), self.tracker.predicted_boxes()
        image = without_faces(image, output, predicted) if self.config.blur else image
        drawn = self.overlay.draw(image, output.detections, output.events, groups, predicted)
        frame, stamp_ns = f'{self.config.camera}_optical_frame', output.events.stamp_ns
        self.debug_image.publish(image_message(drawn, RCLPY_CLASSES, stamp_ns, frame))

    def show_likelihood(self, output: CameraOutput) -> None:
        """Publish likelihoods as a map, while somebody looks."""
        found = output.messages.get(Likelihood.TOPIC)
        if self.likelihood_grid is None or not isinstance(found, Likelihood) or not len(found):
            return
        if self.likelihood_grid.get_subscription_count():
            grid = likelihood_grid(found, self.config.ground_frame)
            self.likelihood_grid.publish(grid)

    def check_stamp(self, stamp_ns: int) -> None:
        """Refuse an image that is no newer than the last; a long step back is a new run."""
        if stamp_ns > self.last_stamp_ns:
            return
        if not starts_anew(stamp_ns, self.last_stamp_ns):
            word = 'again' if stamp_ns == self.last_stamp_ns else 'backwards'
            raise ValueError(f'its stamp {stamp_ns} ns comes {word} after {self.last_stamp_ns}')
        self.get_logger().warning('stamps step back by more than a second: the camera begins anew')
        self.forget_feedback()

    def refuse(self, reason: str) -> None:
        """Count and report input that cannot be used; the node lives on."""
        self.health.count('refused')
        self.get_logger().warning(reason, throttle_duration_sec=5.0)

    def send(self, publisher: LifecyclePublisher, message: Message) -> None:
        """Publish rows or a mask, if anybody takes it: to compress masks takes time."""
        if publisher.get_subscription_count():
            frame = self.config.ground_frame
            publisher.publish(ros_from_message(message, RCLPY_CLASSES, frame))


def main() -> int:
    """Run the node."""
    return run(CameraNode)


if __name__ == '__main__':
    sys.exit(main())
