"""All parameters of the silhouette tracker, and those of the paper's own version."""

from __future__ import annotations

from dataclasses import dataclass, field

from mctrack_ros.perception.identity import IdentityConfig
from mctrack_ros.perception.silhouettes.background import LowPassConfig
from mctrack_ros.perception.silhouettes.classes import ClassConfig
from mctrack_ros.perception.silhouettes.components import ComponentConfig
from mctrack_ros.perception.silhouettes.partition import DivisionConfig
from mctrack_ros.perception.silhouettes.places import PlaceConfig
from mctrack_ros.perception.silhouettes.reporting import ReportConfig
from mctrack_ros.perception.silhouettes.rest import RestConfig
from mctrack_ros.perception.silhouettes.tracker import SilhouetteTrackerConfig
from mctrack_ros.perception.watchdog import WatchdogConfig


@dataclass(frozen=True)
class SilhouetteConfig:
    """Parameters of `SilhouettePipeline`; the defaults are what measures best."""

    background: LowPassConfig = field(default_factory=LowPassConfig)
    components: ComponentConfig = field(default_factory=ComponentConfig)
    tracker: SilhouetteTrackerConfig = field(default_factory=SilhouetteTrackerConfig)
    rest: RestConfig = field(default_factory=RestConfig)
    classes: ClassConfig = field(default_factory=ClassConfig)
    places: PlaceConfig = field(default_factory=PlaceConfig)
    report: ReportConfig = field(default_factory=ReportConfig)
    identity: IdentityConfig = field(default_factory=IdentityConfig)
    watchdog: WatchdogConfig = field(default_factory=WatchdogConfig)


def as_printed() -> SilhouetteConfig:
    """Return the parameters of the silhouettes paper itself, nothing beyond it."""
    return SilhouetteConfig(
        tracker=SilhouetteTrackerConfig(division=DivisionConfig(line='regression'))
    )
