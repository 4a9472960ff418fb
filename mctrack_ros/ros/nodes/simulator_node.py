"""The synthetic match or car park, live: images of its cameras and the truth, on topics."""

from __future__ import annotations

import sys
import threading
from dataclasses import dataclass, replace

from rclpy.lifecycle import LifecyclePublisher
from sensor_msgs.msg import CompressedImage, PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import cloud_from_rows, compressed_message, jpeg_from_image
from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.interfaces import Rows
from mctrack_ros.ros.health.schedule_health import ScheduleHealth
from mctrack_ros.ros.node.diagnostics import Diagnostics
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.simulation import CARPARK, SCENES, EventWatcher, true_detections, true_tracks
from mctrack_ros.simulation.pitch.ptz import PtzCamera
from mctrack_ros.simulation.recording import true_calibration

_REPORT_S = 10.0


@dataclass(frozen=True, slots=True)
class SimulatorNodeConfig:
    """Parameters of `simulator_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    scene: str = parameter(
        'pitch5',
        'scene; for carpark set cameras [cam1], rate 4, shadows true, noise 2.6 and '
        'lighting_drift 0.06, as the silhouettes paper has it; for indoor cameras [cam1, cam2, '
        'cam3, cam4], duration 23.6 and distortion -0.05; for grey_carpark these cameras, rate '
        '12.5 and the rest as for carpark; for hall these cameras, rate 12.5, duration 55 and '
        'shadows true; for ptz cameras [cam1, cam2]',
        choices=('pitch5', 'ptz', 'carpark', 'indoor', 'grey_carpark', 'hall'),
    )
    cameras: tuple[str, ...] = parameter(
        ('cam1', 'cam2', 'cam3', 'cam4', 'cam5'), 'cameras that this node renders'
    )
    ground_frame: str = parameter('map', 'frame_id of positions on the ground')
    seed: int = parameter(1, 'the same seed gives the same recording', minimum=0)
    duration: float = parameter(
        120.0, 'length of the recording, then it begins again [s]', minimum=1.0, maximum=3600.0
    )
    rate: float = parameter(25.0, 'images a second [Hz]', minimum=1.0, maximum=100.0)
    noise: float = parameter(
        2.0, 'standard deviation of the sensor noise [grey levels]', minimum=0.1, maximum=50.0
    )
    shadows: bool = parameter(False, 'draw shadows of the players')
    bicycles: bool = parameter(False, 'let bicycles ride through the car park')
    distortion: float = parameter(
        0.0, 'first radial coefficient of the lenses; 0: pinhole', minimum=-1.0, maximum=1.0
    )
    lighting_drift: float = parameter(
        0.0, 'relative amplitude of the slow change of brightness', minimum=0.0, maximum=1.0
    )
    truth: bool = parameter(True, 'publish the truth below truth/')
    quality: int = parameter(90, 'JPEG quality [%]', minimum=1, maximum=100)
    reliable: bool = parameter(True, 'reliable transport: lost messages are sent again')
    depth: int = parameter(8, 'length of the queue of images', minimum=1, maximum=1000)


class SimulatorNode(GraphNode):
    """
    Render some or all cameras of a scene, from a thread of its own.

    The period of the clock decides which step is shown, so simulators with the same parameters
    show the same at the same time: one node a camera shares the work among processes.

    """

    CONFIG = SimulatorNodeConfig
    config: SimulatorNodeConfig

    def __init__(self) -> None:
        super().__init__('simulator_node')

    def open(self) -> None:
        """Simulate what goes on and draw the empty images."""
        config, scene = self.config, SCENES[self.config.scene]
        if config.bicycles and scene is not CARPARK:
            raise ConfigError('bicycles come with scene carpark only')
        more = {'bicycles': True} if config.bicycles else {}
        self.world = scene.world(
            scene.scenario(
                seed=config.seed,
                duration_s=config.duration,
                rate_hz=config.rate,
                noise=config.noise,
                shadows=config.shadows,
                distortion=config.distortion,
                lighting_drift=config.lighting_drift,
                **more,
            )
        )
        names = [camera.name for camera in self.world.cameras]
        if not config.cameras or not set(config.cameras) <= set(names):
            raise ConfigError(f'cameras is {list(config.cameras)}, expected some of {names}')
        self.renderers = {
            name: scene.renderer(self.world, names.index(name)) for name in config.cameras
        }
        images = quality.images(config.reliable, config.depth)
        self.images = {
            name: self.publisher(CompressedImage, f'{name}/image_raw/compressed', images)
            for name in config.cameras
        }
        if config.truth:
            self.true_tracks = self.publisher(PointCloud2, 'truth/tracks', quality.reliable(10))
            self.true_detections = {
                name: self.publisher(PointCloud2, f'truth/{name}/detections', quality.reliable(10))
                for name in config.cameras
            }
            self.true_events = {
                name: self.publisher(PointCloud2, f'truth/{name}/events', quality.reliable(10))
                for name in config.cameras
            }
            self.true_calibrations = {
                camera.name: self.publisher(
                    String, f'truth/{camera.name}/calibration', quality.reliable(10)
                )
                for camera in self.world.cameras
                if isinstance(camera, PtzCamera) and camera.name in config.cameras
            }
        self.watch_anew()
        self.ending = threading.Event()
        self.step = 0
        self.health = ScheduleHealth(lambda: 'showing')
        self.diagnostics = Diagnostics(self, {'images': self.health}, ())

    def start(self) -> None:
        """Begin to show."""
        self.ending.clear()
        self.diagnostics.begin()
        self.every(_REPORT_S, self.report)
        self.thread = threading.Thread(target=self.show, name='show')
        self.thread.start()

    def stop(self) -> None:
        """End in the middle."""
        self.ending.set()
        self.thread.join()
        self.report()

    def report(self) -> None:
        """Say whether rendering keeps up."""
        self.get_logger().info(f'{self.health.sent} periods shown, {self.health.skipped} skipped')

    def show(self) -> None:
        """Show each period in its middle; periods that cannot be kept up with are skipped."""
        scenario = self.world.scenario
        period_ns = round(scenario.period_s * 1e9)
        last = None
        try:
            while not self.ending.is_set():
                now_ns = self.get_clock().now().nanoseconds
                index = (now_ns + period_ns // 2) // period_ns
                if last is not None:
                    self.health.skipped += max(index - last - 1, 0)
                    index = max(index, last + 1)
                stamp_ns = index * period_ns + period_ns // 2
                if self.ending.wait(max(stamp_ns - now_ns, 0) * 1e-9):
                    return
                self.show_step(index % scenario.steps, stamp_ns)
                self.health.add(self.get_clock().now().nanoseconds - stamp_ns)
                last = index
        except Exception as error:
            self.fail(str(error))

    def show_step(self, step: int, stamp_ns: int) -> None:
        """Publish all cameras' images of a step, then the truth."""
        if step < self.step:
            self.watch_anew()
        self.step = step
        views = {}
        for name, renderer in self.renderers.items():
            image, views[name] = renderer.frame(step)
            jpeg = jpeg_from_image(image, self.config.quality)
            frame = f'{name}_optical_frame'
            self.images[name].publish(compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, frame))
        if self.config.truth:
            self.send(self.true_tracks, true_tracks(self.world, step), stamp_ns)
            views_of = {camera.name: camera for camera in self.world.views(step)}
            for name, publisher in self.true_calibrations.items():
                text = true_calibration(views_of[name], stamp_ns)
                publisher.publish(String(data=text))
            for name, view in views.items():
                rows = true_detections(self.world, step, view)
                self.send(self.true_detections[name], rows, stamp_ns)
                if len(events := self.watchers[name].step(step, view)):
                    self.send(self.true_events[name], events, stamp_ns)

    def watch_anew(self) -> None:
        """Forget what happened: the recording begins, or begins again."""
        names = [camera.name for camera in self.world.cameras]
        self.watchers = {
            name: EventWatcher(self.world, names.index(name)) for name in self.renderers
        }

    def send(self, publisher: LifecyclePublisher, rows: Rows, stamp_ns: int) -> None:
        """Publish rows at the time they are shown."""
        moved = replace(rows, stamp_ns=stamp_ns)
        publisher.publish(cloud_from_rows(moved, RCLPY_CLASSES, self.config.ground_frame))


def main() -> int:
    """Run the node."""
    return run(SimulatorNode)


if __name__ == '__main__':
    sys.exit(main())
