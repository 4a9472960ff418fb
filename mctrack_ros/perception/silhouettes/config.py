"""All parameters of the silhouette tracker, and those of the paper's own version."""

from __future__ import annotations

from dataclasses import dataclass, field

from mctrack_ros.config import parameter, tag
from mctrack_ros.perception.background.model import BackgroundConfig
from mctrack_ros.perception.background.shadows import ShadowConfig
from mctrack_ros.perception.camera_shift.monitor import CameraShiftConfig
from mctrack_ros.perception.config import CameraConfig
from mctrack_ros.perception.silhouettes.features import ComparisonConfig
from mctrack_ros.perception.silhouettes.foreground.components import ComponentConfig
from mctrack_ros.perception.silhouettes.foreground.fragment_merging import FragmentMergingConfig
from mctrack_ros.perception.silhouettes.ground_position import PlaceConfig
from mctrack_ros.perception.silhouettes.matching.match import MatchConfig
from mctrack_ros.perception.silhouettes.matching.partition import DivisionConfig
from mctrack_ros.perception.silhouettes.objects import ObjectConfig
from mctrack_ros.perception.silhouettes.reference_update.absorption import AbsorptionConfig
from mctrack_ros.perception.silhouettes.reference_update.holes import HoleConfig
from mctrack_ros.perception.silhouettes.reference_update.stationary_false_foreground import (
    FalseForegroundConfig,
)
from mctrack_ros.perception.silhouettes.reporting import ReportConfig
from mctrack_ros.perception.silhouettes.tracker import SilhouetteTrackerConfig


@dataclass(frozen=True)
class SubtractionConfig:
    """How the shared background is subtracted."""

    threshold: float = parameter(
        7.0, 'difference above which a pixel is foreground at least [grey levels]', minimum=1.0
    )
    threshold_sigmas: float = parameter(
        5.0,
        'the same in standard deviations of the measured noise; 0: as printed',
        minimum=0.0,
    )
    shadow_share: float = parameter(
        0.13,
        'what is darker by no more than this share may be a shadow: neither foreground nor '
        'learned; 0: as printed',
        minimum=0.0,
        maximum=0.9,
    )
    smoothing_px: int = parameter(
        3, 'images are averaged over squares of this side; 1: not', minimum=1, maximum=15
    )

    def background(self) -> BackgroundConfig:
        """Return the parameters of the background, which only the tracker mends."""
        return BackgroundConfig(
            minimum_threshold=self.threshold, threshold_sigmas=self.threshold_sigmas, still_s=0.0
        )

    def shadows(self) -> ShadowConfig:
        """Return those of the shadows: in grey images nobody knows where the sun is."""
        return ShadowConfig(suppress=False, faint_share=self.shadow_share)


@dataclass(frozen=True)
class SilhouetteConfig:
    """Parameters of `SilhouettePipeline`; the defaults are what measures best."""

    background: SubtractionConfig = field(default_factory=SubtractionConfig)
    components: ComponentConfig = field(default_factory=ComponentConfig)
    holes: HoleConfig = field(default_factory=HoleConfig)
    stationary_false_foreground: FalseForegroundConfig = field(
        default_factory=FalseForegroundConfig
    )
    tracker: SilhouetteTrackerConfig = field(default_factory=SilhouetteTrackerConfig)
    absorption: AbsorptionConfig = field(default_factory=AbsorptionConfig)
    ground_position: PlaceConfig = field(default_factory=PlaceConfig)
    report: ReportConfig = field(default_factory=ReportConfig)
    camera_shift: CameraShiftConfig = field(default_factory=CameraShiftConfig)


@dataclass(frozen=True)
class SilhouetteCameraConfig(CameraConfig):
    """Parameters of a camera that tracks by silhouettes."""

    local_tracker: str = tag('silhouettes')
    silhouettes: SilhouetteConfig = field(default_factory=SilhouetteConfig)


def as_printed() -> SilhouetteConfig:
    """Return the parameters of the paper, nothing beyond it but the background's own rules."""
    return SilhouetteConfig(
        background=SubtractionConfig(
            threshold=12.0, threshold_sigmas=0.0, shadow_share=0.0, smoothing_px=1
        ),
        components=ComponentConfig(closing_px=1, learn_specks=False),
        holes=HoleConfig(edge_ratio=0.0),
        stationary_false_foreground=FalseForegroundConfig(still_s=0.0),
        tracker=SilhouetteTrackerConfig(
            fragment_merging=FragmentMergingConfig(
                person_height_m=0.0, least_part_m=0.0, faint_sigmas=0.0
            ),
            comparison=ComparisonConfig(place_weight=0.0),
            match=MatchConfig(distance='centroids', only_valid=False, pedestrian_m=0.0),
            division=DivisionConfig(line='regression', body_height_m=0.0),
            objects=ObjectConfig(
                establish_s=0.2,
                move_px=0.0,
                hold_s=0.0,
                hidden_s=0.0,
                body_s=0.0,
                memory_s=0.0,
                motion_s=0.0,
            ),
        ),
        absorption=AbsorptionConfig(
            rest_s=4.0,
            rest_px=3.0,
            still_share=0.0,
            pedestrian_rest_s=4.0,
            travel_px=0.0,
            hole_px=20.0,
            spare_others=False,
            uncovered_share=0.0,
        ),
        report=ReportConfig(travel_px=0.0),
    )
