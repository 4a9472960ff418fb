"""Parameters of the event-tracking paper's camera tracker."""

from __future__ import annotations

from dataclasses import dataclass, field

from mctrack_ros.config import parameter, tag
from mctrack_ros.perception.background.ghost_removal import GhostConfig
from mctrack_ros.perception.background.model import BACKGROUND, BackgroundConfig
from mctrack_ros.perception.background.shadows import ShadowConfig
from mctrack_ros.perception.blob_split.split import PartitionConfig
from mctrack_ros.perception.blobs.extraction import BlobConfig
from mctrack_ros.perception.camera_shift.monitor import CameraShiftConfig
from mctrack_ros.perception.config import CameraConfig, Sight
from mctrack_ros.perception.events.appearance_events import AppearanceEventsConfig
from mctrack_ros.perception.events.groups import GroupConfig
from mctrack_ros.perception.feedback.id_assignment import IdentityConfig
from mctrack_ros.perception.feedback.persons_in_view import PersonsInViewConfig
from mctrack_ros.perception.local_tracks.association import MatchingConfig
from mctrack_ros.perception.local_tracks.classification import BicycleConfig, ClassConfig
from mctrack_ros.perception.local_tracks.table import FilterConfig
from mctrack_ros.tracking.appearance import PALETTES


@dataclass(frozen=True)
class TrackerConfig:
    """Parameters of `LocalTracker`."""

    confirm_s: float = parameter(
        0.2, 'time after which a local track is believed [s]', minimum=0.0
    )
    coast_s: float = parameter(
        0.8, 'time that a local track lives without a detection [s]', minimum=0.0
    )
    hidden_s: float = parameter(
        3.0, 'time that a track stays in a group no larger than one person [s]', minimum=0.0
    )
    vehicles: bool = parameter(
        False,
        'whether vehicles and bicycles come too: what is as large as a vehicle, and was not seen '
        'to gather, is one; what is long, thin and fast is a bicycle',
    )
    template: str = parameter(
        'mixed',
        'what is kept of looks: hue and brightness, hue alone, both in slices, brightness alone',
        choices=tuple(PALETTES),
    )
    template_time_s: float = parameter(
        1.0, 'time constant with which the template follows the colours [s]', minimum=0.0
    )


@dataclass(frozen=True)
class EventTrackerConfig(CameraConfig):
    """Parameters of `EventTracker`."""

    local_tracker: str = tag('groups')
    reduction: int = parameter(
        1, 'images are reduced by this factor before the background', minimum=1, maximum=4
    )
    background: BackgroundConfig = BACKGROUND.field()
    shadows: ShadowConfig = field(default_factory=ShadowConfig)
    blobs: BlobConfig = field(default_factory=BlobConfig)
    ghosts: GhostConfig = field(default_factory=GhostConfig)
    filter: FilterConfig = field(default_factory=FilterConfig)
    matching: MatchingConfig = field(default_factory=MatchingConfig)
    partition: PartitionConfig = field(default_factory=PartitionConfig)
    company: PersonsInViewConfig = field(default_factory=PersonsInViewConfig)
    groups: GroupConfig = field(default_factory=GroupConfig)
    presence: AppearanceEventsConfig = field(default_factory=AppearanceEventsConfig)
    identity: IdentityConfig = field(default_factory=IdentityConfig)
    classes: ClassConfig = field(default_factory=ClassConfig)
    bicycles: BicycleConfig = field(default_factory=BicycleConfig)
    tracker: TrackerConfig = field(default_factory=TrackerConfig)
    watchdog: CameraShiftConfig = field(default_factory=CameraShiftConfig)

    @property
    def sight(self) -> Sight:
        """How far the tracker sees people, and how precisely."""
        return Sight(
            self.blobs.person_height_m,
            self.blobs.farthest_height_px,
            self.filter.foot_noise_px,
            self.filter.foot_noise_share,
        )
