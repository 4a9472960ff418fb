"""What every node of the graph can be told: its parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mctrack_ros.camera_settings import CameraSettings
from mctrack_ros.config import parameter
from mctrack_ros.fusion import FusionConfig
from mctrack_ros.ground.coverage import CoverageConfig

_AUTOSTART = 'configure and activate on start; false: wait for the lifecycle services'


@dataclass(frozen=True, slots=True)
class CameraNodeConfig:
    """Parameters of `camera_node`."""

    autostart: bool = parameter(True, _AUTOSTART)
    camera: str = parameter('cam1', 'name of the camera; its topics lie below it')
    ground_frame: str = parameter('map', 'frame_id of positions on the ground')
    period: float = parameter(0.04, "the fusion node's period [s]", minimum=0.001, maximum=10.0)
    feedback_delay: float = parameter(
        0.08, 'age of the feedback that a picture uses [s]', minimum=0.0, maximum=10.0
    )
    reliable: bool = parameter(False, 'ask again for pictures that got lost')
    depth: int = parameter(
        2,
        'pictures that may queue; the oldest are passed over when the node falls behind',
        minimum=1,
        maximum=1000,
    )
    settings: CameraSettings = CameraSettings()


@dataclass(frozen=True, slots=True)
class FusionNodeConfig:
    """Parameters of `fusion_node`."""

    autostart: bool = parameter(True, _AUTOSTART)
    cameras: tuple[str, ...] = parameter(('cam1',), 'names of the cameras, in order')
    ground_frame: str = parameter('map', 'frame of ground positions')
    obstacle_height: float = parameter(
        0.5, 'height of the points on /tracks/obstacles [m]', minimum=0.0, maximum=10.0
    )
    fusion: FusionConfig = FusionConfig()


@dataclass(frozen=True, slots=True)
class CoverageNodeConfig:
    """Parameters of `coverage_node`."""

    autostart: bool = parameter(True, _AUTOSTART)
    site: str = parameter('', 'site YAML, with the cameras and their calibrations')
    area: str = parameter(
        '',
        'what is to be covered: x0,y0,x1,y1 or the corners x,y of a polygon; empty: what the '
        'site says [m]',
    )
    coverage: CoverageConfig = CoverageConfig()


@dataclass(frozen=True, slots=True)
class VideoNodeConfig:
    """Parameters of `video_node`."""

    autostart: bool = parameter(True, _AUTOSTART)
    camera: str = parameter('cam1', 'name of the camera; its topics lie below it')
    source: str = parameter('', 'video file, device (number or path) or stream (rtsp://...)')
    rate: float = parameter(
        0.0, 'pictures a second; 0: what the source states [Hz]', minimum=0.0, maximum=1000.0
    )
    realtime: bool = parameter(True, 'play a file at its rate; false: as fast as possible')
    loop: bool = parameter(False, 'start a file again at its end')
    start: float = parameter(
        0.0,
        'time of the first picture of a file, so that several play in step; 0: now '
        '[s since the epoch]',
        minimum=0.0,
    )
    image_topic: str = parameter(
        'image_raw/compressed',
        'pictures, relative to the camera; a name ending in /compressed holds JPEG',
    )
    quality: int = parameter(90, 'JPEG quality [%]', minimum=1, maximum=100)
    width: int = parameter(0, 'scale pictures to this width; 0: keep [px]', minimum=0)
    height: int = parameter(0, 'scale pictures to this height; 0: keep [px]', minimum=0)
    wait: float = parameter(
        10.0, 'a file waits this long for a subscriber [s]', minimum=0.0, maximum=3600.0
    )
    reliable: bool = parameter(True, 'send again what got lost')
    depth: int = parameter(8, 'pictures that may queue', minimum=1, maximum=1000)


@dataclass(frozen=True, slots=True)
class RecorderConfig:
    """Parameters of `recorder`."""

    autostart: bool = parameter(True, _AUTOSTART)
    path: str = parameter('', 'directory of the bag')
    overwrite: bool = parameter(False, 'replace a bag that is there')
    topics: tuple[str, ...] = parameter(
        ('.*',), 'regular expressions; a topic whose whole name matches one is recorded'
    )
    exclude: str = parameter(
        '/(clock|rosout|parameter_events)|.*/(transition_event|debug_image)',
        'regular expression of topics that are not',
    )
    explain: bool = parameter(
        False, 'record why fusion decided as it did, too; it is worked out only if somebody asks'
    )
    depth: int = parameter(100, 'messages of a topic that may queue', minimum=1, maximum=10000)


@dataclass(frozen=True, slots=True)
class PlayerConfig:
    """Parameters of `player`."""

    autostart: bool = parameter(True, _AUTOSTART)
    path: str = parameter('', 'directory of the bag')
    topics: tuple[str, ...] = parameter(
        ('.*',), 'regular expressions; a topic whose whole name matches one is played'
    )
    rate: float = parameter(1.0, 'speed; 1: as recorded', minimum=0.001, maximum=1000.0)
    start: float = parameter(0.0, 'where in the bag to begin [s]', minimum=0.0)
    duration: float = parameter(0.0, 'how much of it to play; 0: all [s]', minimum=0.0)
    loop: bool = parameter(False, 'begin again at the end')
    restamp: bool = parameter(
        False, 'shift all stamps as if captured now, for nodes on system time; no /clock'
    )
    clock_rate: float = parameter(
        100.0, '/clock messages a second, besides one a message [Hz]', minimum=1.0, maximum=1000.0
    )
    wait_for: tuple[str, ...] = parameter(
        ('.*/image_raw(/compressed)?',),
        'regular expressions of topics, of the bag or of the graph; playing starts when each '
        'matches some and all those have a subscriber, or as many as stand after a blank',
    )
    wait: float = parameter(
        20.0, 'how long to wait for them, then start anyway [s]', minimum=0.0, maximum=3600.0
    )
    settle: float = parameter(
        3.5,
        'pause between the last match and the first message; DDS takes up to 3 s to say again '
        'what got lost while the nodes met [s]',
        minimum=0.0,
        maximum=60.0,
    )
    depth: int = parameter(100, 'messages of a topic that may queue', minimum=1, maximum=10000)


@dataclass(frozen=True, slots=True)
class SimulatorNodeConfig:
    """Parameters of `simulator_node`."""

    autostart: bool = parameter(True, _AUTOSTART)
    scene: str = parameter(
        'pitch5',
        'what is shown; carpark: cameras [cam1], rate 4, shadows, noise 2.6 and lighting_drift '
        '0.06 are as the silhouettes paper has it',
        choices=('pitch5', 'carpark'),
    )
    cameras: tuple[str, ...] = parameter(
        ('cam1', 'cam2', 'cam3', 'cam4', 'cam5'), 'cameras that this node renders'
    )
    ground_frame: str = parameter('map', 'frame_id of positions on the ground')
    seed: int = parameter(1, 'the same seed gives the same recording', minimum=0)
    duration: float = parameter(
        120.0, 'length of the recording, then it begins again [s]', minimum=1.0, maximum=3600.0
    )
    rate: float = parameter(25.0, 'pictures a second [Hz]', minimum=1.0, maximum=100.0)
    noise: float = parameter(
        2.0, 'standard deviation of the sensor noise [grey levels]', minimum=0.1, maximum=50.0
    )
    shadows: bool = parameter(False, 'players throw shadows')
    distortion: float = parameter(
        0.0, 'first radial coefficient of the lenses; 0: pinhole', minimum=-1.0, maximum=1.0
    )
    lighting_drift: float = parameter(
        0.0, 'relative amplitude of the slow change of brightness', minimum=0.0, maximum=1.0
    )
    truth: bool = parameter(True, 'publish the truth below truth/')
    quality: int = parameter(90, 'JPEG quality [%]', minimum=1, maximum=100)
    reliable: bool = parameter(True, 'send again what got lost')
    depth: int = parameter(8, 'pictures that may queue', minimum=1, maximum=1000)


NODE_CONFIGS: dict[str, type[Any]] = {
    'camera_node': CameraNodeConfig,
    'fusion_node': FusionNodeConfig,
    'coverage_node': CoverageNodeConfig,
    'video_node': VideoNodeConfig,
    'simulator_node': SimulatorNodeConfig,
    'recorder': RecorderConfig,
    'player': PlayerConfig,
}
"""What configures a node, by its executable."""
