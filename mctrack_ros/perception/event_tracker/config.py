"""Parameters of the event-tracking paper's camera tracker."""

from __future__ import annotations

from dataclasses import dataclass, field

from mctrack_ros.config import parameter, tag
from mctrack_ros.perception.background.model import BackgroundConfig
from mctrack_ros.perception.background.shadows import ShadowConfig
from mctrack_ros.perception.blobs.extraction import BlobConfig
from mctrack_ros.perception.camera_shift.monitor import CameraShiftConfig
from mctrack_ros.perception.config import CameraConfig, DetectionLimits
from mctrack_ros.perception.events.groups import GroupConfig
from mctrack_ros.perception.local_tracks.association import MatchingConfig
from mctrack_ros.perception.local_tracks.classification import ClassConfig
from mctrack_ros.perception.local_tracks.table import FilterConfig


@dataclass(frozen=True)
class TrackerConfig:
    """Parameters of `LocalTracker`."""

    confirm_s: float = parameter(
        0.2, 'time after which a local track is confirmed [s]', minimum=0.0, at_run_time=True
    )
    coast_s: float = parameter(
        0.8,
        'time that a local track lives without a detection [s]',
        minimum=0.0,
        at_run_time=True,
    )
    hidden_s: float = parameter(
        3.0,
        "time that a hidden track is kept in a blob of one person's size [s]",
        minimum=0.0,
        at_run_time=True,
    )
    vehicles: bool = parameter(
        False,
        "whether vehicles and bicycles are detected: a blob of a vehicle's size is one unless "
        'it formed from tracked people; a long, thin and fast one is a bicycle',
    )


@dataclass(frozen=True)
class EventTrackerConfig(CameraConfig):
    """Parameters of `EventTracker`."""

    local_tracker: str = tag('event_tracker')
    reduction: int = parameter(
        1, 'images are reduced by this factor before the background', minimum=1, maximum=4
    )
    background: BackgroundConfig = field(default_factory=BackgroundConfig)
    shadows: ShadowConfig = field(default_factory=ShadowConfig)
    blobs: BlobConfig = field(default_factory=BlobConfig)
    filter: FilterConfig = field(default_factory=FilterConfig)
    matching: MatchingConfig = field(default_factory=MatchingConfig)
    groups: GroupConfig = field(default_factory=GroupConfig)
    classes: ClassConfig = field(default_factory=ClassConfig)
    tracker: TrackerConfig = field(default_factory=TrackerConfig)
    camera_shift: CameraShiftConfig = field(default_factory=CameraShiftConfig)

    @property
    def limits(self) -> DetectionLimits:
        """How far the tracker sees people, and how precisely."""
        return DetectionLimits(
            self.blobs.person_height_m,
            self.blobs.farthest_height_px,
            self.filter.foot_noise_px,
            self.filter.foot_noise_share,
        )
