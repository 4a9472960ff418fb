"""All cameras: detections in, tracks, feedback and events out."""

from __future__ import annotations

import json
import sys
import time
import uuid
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray, PoseStamped
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecyclePublisher
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from mctrack_ros.codec import (
    cloud_from_rows,
    further_fields,
    message_from_ros,
    rows_from_cloud,
)
from mctrack_ros.config import ConfigError, parameter, replace_parameters, values_of
from mctrack_ros.fusion import (
    FUSION,
    START_TOPIC,
    FusionConfig,
    Joining,
    Startable,
    Views,
    fusion_method,
    joined,
    open_batcher,
    open_fusion,
    open_recorder,
)
from mctrack_ros.fusion.camera_clocks import Jump
from mctrack_ros.fusion.clock_offsets.clock_offsets import ClockOffsets
from mctrack_ros.fusion.occupancy.masks import Unusable
from mctrack_ros.fusion.trackers import COMPILED_ON_DEMAND
from mctrack_ros.interfaces import (
    MAX_CAMERAS,
    Detections,
    EventCode,
    Events,
    Foreground,
    Rows,
    RowsTick,
    Tracks,
)
from mctrack_ros.recording.track_log.provenance import provenance
from mctrack_ros.replay.proof.state import (
    StateError,
    go_on_with,
    take_state,
)
from mctrack_ros.ros.health.stream_health import DiagnosticsConfig
from mctrack_ros.ros.health.tracking_health import TrackingHealth
from mctrack_ros.ros.interop.followed import Followed
from mctrack_ros.ros.interop.track_arrays import TrackArrays
from mctrack_ros.ros.node.camera_agreement import MaskHealth, agreements
from mctrack_ros.ros.node.clock_health import (
    ClockAgreement,
    ClockJumps,
    MotionClocks,
    ahead_from,
    clock_message,
)
from mctrack_ros.ros.node.diagnostics import Diagnostics, Health, stream_health
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.loops import compile_loops
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.state.track_ids import TrackIds, state_path
from mctrack_ros.ros.state.tracker_state import TrackerState
from mctrack_ros.ros.topics import markers, quality
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES, message_class
from mctrack_ros.site.description import Beginning, site_description
from mctrack_ros.site.names import check_camera_name
from mctrack_ros.site.stated_origin import origin_from, origin_text
from mctrack_ros.zones.engine import ZoneEngine
from mctrack_ros.zones.shapes import Zones


@dataclass(frozen=True, slots=True)
class FusionNodeConfig:
    """Parameters of `fusion_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    cameras: tuple[str, ...] = parameter(('cam1',), 'names of the cameras, in order')
    ground_frame: str = parameter('map', 'frame_id of positions on the ground')
    origin: str = parameter(
        '0,0', "x,y of the local origin, in the coordinates of the site's files [m]"
    )
    trail: float = parameter(
        5.0,
        'length of the trails on /tracks/markers; 0: none [s]',
        minimum=0.0,
        maximum=60.0,
        at_run_time=True,
    )
    obstacle_height: float = parameter(
        0.5,
        'height of the points on /tracks/obstacles [m]',
        minimum=0.0,
        maximum=10.0,
        at_run_time=True,
    )
    follow: int = parameter(
        0,
        'id of the track whose pose is on /followed, also after corrections; 0: none',
        minimum=0,
        maximum=0xFFFFFFFF,
        at_run_time=True,
    )
    state_file: str = parameter(
        'auto',
        'file of the ids used so far, so that none is used again; auto: a file of this node '
        'below ROS_HOME or ~/.ros; empty: none, ids begin at 1 at each configuration',
    )
    resume: float = parameter(
        20.0,
        'a node that starts so soon after it was killed or stopped goes on with its tracks and '
        'their ids; 0: it begins anew [s]',
        minimum=0.0,
        maximum=3600.0,
    )
    site: str = parameter(
        '',
        'site YAML with the zones and lines whose events are published, and the calibrations of '
        'the cameras, for a tracker that has to know them: occupancy, likelihood_grid',
    )
    private: bool = parameter(
        False, 'say on /site that no picture may be recorded; recorders obey'
    )
    clock_offsets: str = parameter(
        '',
        "by how much cameras' clocks are ahead, which is taken from their stamps: camera=seconds, "
        'separated by commas; the nodes of a site are given its clock_offset of each camera',
    )
    diagnostics: DiagnosticsConfig = DiagnosticsConfig()
    fusion: FusionConfig = FUSION.field()


_PACE_NS = 200_000_000
"""Time over which the pace of simulated time is measured, ns."""


class FusionNode(GraphNode):
    """The server of the event-tracking paper, section 4.3, as a node."""

    CONFIG = FusionNodeConfig
    config: FusionNodeConfig

    def __init__(self) -> None:
        super().__init__('fusion_node')
        self.ids: TrackIds | None = None
        self.run = ''
        self.image_sizes: dict[str, tuple[int, int]] = {}

    def open(self) -> None:
        """Build batcher and tracker and the publishers."""
        cameras = self.config.cameras
        if not 1 <= len(set(cameras)) == len(cameras) <= MAX_CAMERAS:
            raise ConfigError(
                f'cameras is {list(cameras)}, expected 1 to {MAX_CAMERAS} different names'
            )
        for camera in cameras:
            check_camera_name(camera)
        compile_loops('mctrack_ros.fusion', *COMPILED_ON_DEMAND)
        self.open_batcher()
        self.open_tracker()
        compile_loops(type(self.tracker).__module__.rpartition('.')[0])
        self.open_health()
        self.open_topics()

    def open_batcher(self) -> None:
        """Build what sorts the cameras' messages into ticks."""
        config = self.config
        self.batcher = open_batcher(config.fusion, config.cameras)
        self.batcher.ahead_ns |= ahead_from(config.clock_offsets, config.cameras)
        self.method = fusion_method(config.fusion)
        self.joining = Joining(config.fusion)
        self.paced_ns = 0, 0

    def open_tracker(self) -> None:
        """Build the tracker, with ids that no earlier run used, and what watches its tracks."""
        self.origin = origin_from(self.config.origin)
        self.zones = self.own_zones()
        self.zone_engine = ZoneEngine(self.zones)
        ids = self.open_ids()
        try:
            self.tracker = open_fusion(
                self.config.fusion, self.config.cameras, ids.first, self.views
            )
        except ValueError:
            ids.close(ids.first)
            raise
        self.ids = ids
        self.described: set[str] = set()
        self.left_out: set[str] = set()
        self.jump: Jump | None = None
        self.go_on()

    def open_health(self) -> None:
        """Build what `/diagnostics` tells of."""
        assert self.ids is not None
        cameras = self.config.cameras
        self.health = {camera: stream_health(self) for camera in cameras}
        self.tracking = TrackingHealth(lambda: self.config.diagnostics, cameras)
        self.motion_clocks = self.own_motion_clocks()
        self.unexplained: Counter[str] = Counter()
        self.masks: dict[str, MaskHealth] = {}
        if Foreground in self.method.messages:
            self.masks = {camera: MaskHealth() for camera in cameras}
        parts: dict[str, Health] = {
            **self.health,
            **agreements(cameras, self.tracker.bias),
            **{f'{camera} clock': ClockAgreement(self.batcher, camera) for camera in cameras},
            'clocks': ClockJumps(self.batcher.clocks, self.motion_clocks),
            'ids': self.ids,
            'restart': self.state,
            'tracking': self.tracking,
            **{f'{camera} mask': health for camera, health in self.masks.items()},
        }
        self.diagnostics = Diagnostics(self, parts, cameras)

    def open_topics(self) -> None:
        """Make the publishers."""
        cloud, reliable = PointCloud2, quality.reliable
        self.tracks = self.publisher(cloud, Tracks.TOPIC, reliable(10))
        self.feedback = self.publisher(cloud, self.method.feedback.TOPIC, reliable(10))
        self.events = self.publisher(cloud, 'events', reliable(100))
        self.ticks = self.publisher(cloud, 'ticks', reliable(100))
        self.candidates = self.publisher(cloud, 'explanation/candidates', reliable(100))
        self.decisions = self.publisher(cloud, 'explanation/decisions', reliable(100))
        self.site = self.publisher(String, 'site', quality.latched())
        self.open_detections()
        self.open_displays()

    def open_displays(self) -> None:
        """Make the publishers of what RViz and navigation show and take."""
        reliable = quality.reliable
        self.followed = Followed(self.config.follow)
        self.pose = self.publisher(PoseStamped, 'followed', reliable(1))
        self.track_markers = markers.TrackMarkers(self.config.ground_frame, self.config.trail)
        self.markers = self.publisher(MarkerArray, 'tracks/markers', reliable(1))
        self.poses = self.publisher(PoseArray, 'tracks/poses', reliable(1))
        self.obstacles = self.publisher(PointCloud2, 'tracks/obstacles', reliable(1))

    def open_detections(self) -> None:
        """Also publish tracks as vision_msgs has them, where that is installed."""
        self.arrays: TrackArrays | None = None
        try:
            self.arrays = TrackArrays()
        except ValueError:
            return
        self.detections = self.publisher(
            self.arrays.kind, 'tracks/detections', quality.reliable(1)
        )

    def own_motion_clocks(self) -> MotionClocks | None:
        """Return what compares clocks by who moves; None: that is switched off, or of one."""
        config, cameras = self.config.fusion.clocks, self.config.cameras
        if not config.window or len(cameras) < 2:
            return None
        return MotionClocks(config, self.batcher, ClockOffsets(cameras, config.window))

    def own_zones(self) -> Zones:
        """Read the zones and lines of the site, relative to its origin."""
        from mctrack_ros.zones.files import read_zones  # with ground's code: only when needed

        if not self.config.site:
            return Zones()
        x, y = self.origin
        return read_zones(self.config.site).moved((-x, -y))

    def views(self) -> Views:
        """Read how the cameras see the ground."""
        from mctrack_ros.site.site import load_site  # with all cameras' code: only when needed

        if not self.config.site:
            tracker = self.config.fusion.tracker
            raise ConfigError(f'fusion.tracker {tracker} has to know the cameras: name the site')
        site = load_site(self.config.site)
        unknown = sorted(set(self.config.cameras) - set(site.cameras))
        if unknown:
            raise ConfigError(f'{self.config.site} lacks cameras: {", ".join(unknown)}')
        if not np.allclose(site.origin, self.origin):
            raise ConfigError(
                f'origin is {self.config.origin}, that of {self.config.site} is '
                f'{origin_text(site.origin)}: give the same'
            )
        self.image_sizes = {name: site.image_sizes[name] for name in self.config.cameras}
        return site.views()

    def go_on(self) -> None:
        """Go on with the tracks of a node that has ended just now, if there was one."""
        assert self.ids is not None
        config = self.config
        fits: dict[str, Any] = {
            'cameras': list(config.cameras),
            'origin': config.origin,
            'site': config.site,
        }
        fits |= {'fusion': json.loads(json.dumps(values_of(config.fusion)))}
        fits |= {'made_by': dict(provenance())}
        path = None if self.ids.path is None else self.ids.path.with_suffix('.tracker')
        self.state = TrackerState(path, 0.0 if self.ids.began_again else config.resume, fits)
        self.before = self.state.find()
        self.beginning = b'' if self.before is None else self.before.data
        self.run = '' if self.before is None else self.before.run
        if self.before is not None:
            go_on_with(self.tracker, self.before.data, self.ids.first)
            self.zone_engine.remember(self.before.zones)
            self.batcher.go_on_after(self.before.stamp_ns)

    def open_ids(self) -> TrackIds:
        """Reserve ids that no earlier run used."""
        node, domain = self.get_fully_qualified_name(), self.context.get_domain_id()
        ids = TrackIds(state_path(self.config.state_file, domain, node))
        if ids.began_again:
            self.get_logger().warning(
                'ids begin at 1 again, as they had come to half of what 32 bits hold: tell ids of '
                'this run from older ones by run on /site'
            )
        return ids

    def start(self) -> None:
        """Subscribe to every camera, and say what the site is."""
        self.after_arrivals = self.create_guard_condition(self.on_overdue)
        self.choice = self.create_service(Trigger, '~/follow_next', self.on_follow_next)
        if self.arrays is None:
            self.get_logger().info('vision_msgs is not installed: no tracks/detections')
        if any(self.origin):
            self.get_logger().info(f'positions are relative to the origin {self.config.origin}')
        self.run = self.run if self.before is not None else uuid.uuid4().hex
        self.describe()
        for camera in self.config.cameras:
            heard = partial(self.on_events, camera)
            self.subscribe(PointCloud2, f'{camera}/events', heard, quality.reliable(100))
            for kind in self.method.messages:
                received, ros_type = (
                    partial(self.on_message, camera, kind),
                    message_class(kind.ROS_TYPE),
                )
                self.subscribe(ros_type, f'{camera}/{kind.TOPIC}', received, quality.reliable(10))
        if isinstance(self.tracker, Startable):
            self.subscribe(PointCloud2, START_TOPIC, self.on_start, quality.reliable(10))
        # Waiting is measured on a clock that no time service moves, unless time is simulated.
        simulated = self.get_parameter('use_sim_time').value
        self.clock = self.get_clock() if simulated else Clock(clock_type=ClockType.STEADY_TIME)
        self.deadline = self.create_timer(3600.0, self.after_deadline, clock=self.clock)
        self.diagnostics.begin()

    def describe(self) -> None:
        """Say on /site what the run is, and with which state what follows begins."""
        values = {
            'cameras': list(self.config.cameras),
            'origin': list(self.origin),
            'fusion': values_of(self.config.fusion),
        } | self.zones.configured()
        values |= {'private': True} if self.config.private else {}
        description = site_description(
            values,
            list(self.config.cameras),
            self.run,
            self.image_sizes,
            Beginning(self.tracker.next_id, provenance(), self.beginning),
        )
        self.site.publish(String(data=description))

    def stop(self) -> None:
        """Fuse what waits; what follows begins with the state after that."""
        self.fuse(self.batcher.flush())
        self.destroy_guard_condition(self.after_arrivals)
        self.destroy_service(self.choice)
        self.followed = Followed(self.config.follow)
        self.before, self.beginning = None, b''
        with suppress(StateError):  # a tracker of somebody else's may have none
            self.beginning = take_state(self.tracker).packed({})

    def close(self) -> None:
        """Keep where the ids of the next run begin."""
        ids, self.ids = self.ids, None
        if ids is not None:
            ids.close(self.tracker.next_id)
            self.state.close(forget=not self.ended)
            if self.motion_clocks is not None:
                self.motion_clocks.close()

    def on_start(self, message: PointCloud2) -> None:
        """Start and end tracks as somebody asks."""
        assert isinstance(self.tracker, Startable)
        try:
            self.tracker.start(rows_from_cloud(message, Detections))
        except ValueError as error:
            self.get_logger().warning(f'{START_TOPIC} refused: {error}')

    def on_events(self, camera: str, message: PointCloud2) -> None:
        """Note for which images a camera had no feedback."""
        try:
            events = rows_from_cloud(message, Events)
        except ValueError as error:
            self.refuse(camera, f'events of {camera} refused: {error}')
            return
        missed = int((events.event == EventCode.FEEDBACK_MISSED).sum())
        if missed:
            self.batcher.feedback_missed(camera, missed)
            self.health[camera].count('feedback missed', missed)

    def on_message(self, camera: str, kind: type[Any], message: Any, info: dict[str, int]) -> None:
        """Give a camera's message to the batcher, and fuse what is complete."""
        try:
            part = message_from_ros(message, kind)
        except ValueError as error:
            self.refuse(camera, f'{kind.TOPIC} of {camera} refused: {error}')
            return
        if camera not in self.described:
            self.note_fields(camera, kind, message)
        parts = self.joining.add(camera, part)
        if parts is None:
            return
        rows = joined(self.method, parts)
        self.health[camera].arrived(rows.stamp_ns, self.get_clock().now().nanoseconds)
        self.fuse(self.batcher.add(camera, rows, *self.arrival_ns(info)))
        self.note_clock(camera)
        self.note_left_out()
        self.set_deadline()

    def note_fields(self, camera: str, kind: type[Any], message: Any) -> None:
        """Say once which fields of a camera are not known: a name may be misspelt."""
        self.described.add(camera)
        if issubclass(kind, Rows) and (further := further_fields(message, kind)):
            self.get_logger().warning(
                f'{camera}/{kind.TOPIC}: fields that are not known are left out: '
                f'{", ".join(further)}'
            )

    def arrival_ns(self, info: dict[str, int]) -> tuple[int, int]:
        """
        Return when a message came in: on the clock of deadlines, and on that of stamps.

        What came in time is not late because this process was kept from looking.

        """
        now_ns = int(self.clock.now().nanoseconds)
        if self.clock.clock_type != ClockType.STEADY_TIME:
            self.note_pace(now_ns)
            return now_ns, now_ns
        received_ns = info['received_timestamp']
        return now_ns - max(time.time_ns() - received_ns, 0), received_ns

    def note_pace(self, now_ns: int) -> None:
        """Measure how fast simulated time goes: a bag may be played fast."""
        steady_ns, (begin_ns, began_ns) = time.monotonic_ns(), self.paced_ns
        if steady_ns - began_ns < _PACE_NS:
            return
        self.paced_ns = now_ns, steady_ns
        if began_ns:
            pace = max((now_ns - begin_ns) / (steady_ns - began_ns), 1.0)
            self.batcher.clocks.set_rate(pace)

    def note_clock(self, camera: str) -> None:
        """Log when a camera is left out because of its clock, and when it is back."""
        clocks = self.batcher.clocks
        if clocks.is_left_out(camera) == (camera in self.left_out):
            return
        self.left_out ^= {camera}
        if camera in self.left_out:
            reason = clock_message(clocks.offset_s(camera))
            self.get_logger().error(f'{camera} is left out: {reason}')
        else:
            self.get_logger().info(f"{camera} is used again: its clock agrees with the others'")

    def note_left_out(self) -> None:
        """Count the messages that were left out, unless a jump of all clocks explains them."""
        clocks = self.batcher.clocks
        if clocks.is_settling:
            return
        if clocks.jump is not self.jump:
            self.jump = clocks.jump
            self.get_logger().warning(str(self.jump))
            self.unexplained.clear()
        for camera, number in self.unexplained.items():
            self.health[camera].count('left out for their stamps', number)
        self.unexplained.clear()

    def after_deadline(self) -> None:
        """Let what has arrived already be admitted first: a timer runs before subscriptions."""
        self.deadline.cancel()
        self.after_arrivals.trigger()

    def on_overdue(self) -> None:
        """Fuse what has waited long enough."""
        self.fuse(self.batcher.poll(self.clock.now().nanoseconds))
        self.set_deadline()

    def set_deadline(self) -> None:
        """Let the timer fire when the oldest waiting tick is due."""
        deadline_ns = self.batcher.deadline_ns()
        if deadline_ns is None:
            self.deadline.cancel()
            return
        wait_ns = max(deadline_ns - self.clock.now().nanoseconds, 0) + 1
        self.deadline.timer_period_ns = wait_ns
        self.deadline.reset()

    def fuse(self, ticks: list[RowsTick[Any]]) -> None:
        """Take ticks through the tracker and publish what comes out."""
        for tick in ticks:
            self.reserve_ids()
            recorder = open_recorder(self.config.fusion) if self.is_asked_why() else None
            output = self.tracker.step(tick, recorder)
            self.send(self.tracks, output.tracks)
            self.send(self.feedback, self.tracker.feedback())
            events = self.zone_engine.added(output.tracks, output.events)
            if len(events):
                self.send(self.events, events)
            self.send(self.ticks, tick.record)
            if recorder is not None:
                self.send(self.candidates, recorder.explanation.candidates)
                self.send(self.decisions, recorder.explanation.decisions)
            self.tracking.published(output, self.get_clock().now().nanoseconds)
            self.count(tick)
            self.keep(output.tracks, at_once=len(events) > 0)
            if self.motion_clocks is not None:
                self.motion_clocks.add(tick, output.tracks)
            self.note_masks(output.left_out)
            self.show(output.tracks)
            frame = self.config.ground_frame
            if pose := self.followed.pose(output.tracks, output.events, frame):
                self.pose.publish(pose)
            if self.followed.track_id != self.config.follow:
                self.follow(self.followed.track_id)  # the id was corrected

    def follow(self, track_id: int) -> None:
        """Set whom to follow, and show it as the parameter."""
        self.set_parameters([Parameter('follow', value=track_id)])

    def on_follow_next(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Follow the next person by id."""
        track_id = self.followed.next_id()
        response.success, response.message = track_id > 0, 'nobody is tracked'
        if response.success:
            self.follow(track_id)
            response.message = str(track_id)
        return response

    def keep(self, tracks: Tracks, at_once: bool) -> None:
        """Keep the state for a restart, and say how long the last one took."""
        stamp_ns = tracks.stamp_ns
        if self.before is not None and self.state.blind_s is None:
            said = self.state.went_on(self.before, stamp_ns, len(tracks))
            self.get_logger().warning(said)
        self.state.keep(self.tracker, self.zone_engine, self.run, stamp_ns, at_once)

    def changed(self, names: set[str], before: FusionNodeConfig) -> None:
        """Follow somebody else, or track by other thresholds, from now on."""
        self.track_markers.trail_s = self.config.trail
        if 'follow' in names:
            self.followed.choose(self.config.follow)
        if self.config.fusion == before.fusion:
            return
        replace_parameters(self.tracker, before.fusion, self.config.fusion)
        self.batcher.max_wait = self.config.fusion.batching.max_wait
        if self.motion_clocks is not None:
            self.motion_clocks.config = self.config.fusion.clocks
        self.beginning = take_state(self.tracker).packed({})
        self.describe()

    def note_masks(self, left_out: Mapping[str, str]) -> None:
        """Keep whose masks are left out; log when that changes, but for a camera's silence."""
        for camera, health in self.masks.items():
            before, health.reason = health.reason, left_out.get(camera, '')
            if before == health.reason or Unusable.SILENT in (before, health.reason):
                continue
            if health.reason:
                self.get_logger().warning(f'the masks of {camera} are left out: {health.reason}')
            else:
                self.get_logger().info(f'the masks of {camera} are used again')

    def reserve_ids(self) -> None:
        """See to it that what the next tick begins has ids of its own for ever."""
        assert self.ids is not None
        try:
            self.ids.keep_ahead(self.tracker.next_id)
        except OSError as error:
            self.get_logger().error(
                f'ids may be used again after a restart: {error}', throttle_duration_sec=60.0
            )

    def is_asked_why(self) -> bool:
        """Tell whether somebody wants explanations."""
        publishers = (self.candidates, self.decisions)
        return any(each.get_subscription_count() for each in publishers)

    def count(self, tick: RowsTick[Any]) -> None:
        """Add what was late, missing or dropped to the diagnostics."""
        record = tick.record
        counts = record.late, record.missing, record.dropped_detections, record.left_out
        for index, late, missing, dropped, left_out in zip(record.camera, *counts):
            health = self.health[self.config.cameras[int(index)]]
            self.unexplained[self.config.cameras[int(index)]] += int(left_out)
            health.count('late', int(late))
            health.count('missing', int(missing))
            health.count('dropped detections', int(dropped))

    def show(self, tracks: Tracks) -> None:
        """Publish markers and images while somebody subscribes."""
        frame = self.config.ground_frame
        if self.markers.get_subscription_count():
            self.markers.publish(self.track_markers.array(tracks))
        if self.poses.get_subscription_count():
            self.poses.publish(markers.pose_array(tracks, frame))
        if self.obstacles.get_subscription_count():
            height = self.config.obstacle_height
            self.obstacles.publish(markers.obstacle_cloud(tracks, frame, height))

        if self.arrays is not None and self.detections.get_subscription_count():
            self.detections.publish(self.arrays.array(tracks, frame))

    def refuse(self, camera: str, reason: str) -> None:
        """Count and report a message that cannot be used; the node lives on."""
        self.health[camera].count('refused')
        self.get_logger().warning(reason, throttle_duration_sec=5.0)

    def send(self, publisher: LifecyclePublisher, rows: Rows) -> None:
        """Publish rows as a cloud."""
        publisher.publish(cloud_from_rows(rows, RCLPY_CLASSES, self.config.ground_frame))


def main() -> int:
    """Run the node."""
    return run(FusionNode)


if __name__ == '__main__':
    sys.exit(main())
