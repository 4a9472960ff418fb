"""What a site's cameras see, as latched occupancy grids."""

from __future__ import annotations

import sys
from dataclasses import dataclass

from nav_msgs.msg import OccupancyGrid

from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.ground.coverage.coverage import CoverageConfig
from mctrack_ros.ros.node.diagnostics import Diagnostics
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.occupancy import error_grid, seen_grid
from mctrack_ros.site.coverage import site_coverage
from mctrack_ros.site.site import load_site


@dataclass(frozen=True, slots=True)
class CoverageNodeConfig:
    """Parameters of `coverage_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    site: str = parameter('', 'site YAML, with the cameras and their calibrations')
    area: str = parameter(
        '',
        'area to cover: x0,y0,x1,y1 or the corners x,y of a polygon; empty: that of the site [m]',
    )
    coverage: CoverageConfig = CoverageConfig()


class CoverageNode(GraphNode):
    """Publish, once and for whoever comes later, how many cameras see a place and how well."""

    CONFIG = CoverageNodeConfig
    config: CoverageNodeConfig

    def __init__(self) -> None:
        super().__init__('coverage_node')

    def open(self) -> None:
        """Compute what the site's cameras see."""
        if not self.config.site:
            raise ConfigError("site is '', expected the site YAML")
        site = load_site(self.config.site)
        self.frame = site.ground_frame
        raster = site_coverage(site, self.config.coverage, self.config.area).raster
        self.raster = raster.moved([-along for along in site.origin])
        self.seen = self.publisher(OccupancyGrid, 'coverage', quality.latched())
        self.error = self.publisher(OccupancyGrid, 'coverage/error', quality.latched())
        self.diagnostics = Diagnostics(self, {}, ())

    def start(self) -> None:
        """Say it."""
        self.diagnostics.begin()
        self.seen.publish(seen_grid(self.raster, self.frame))
        self.error.publish(error_grid(self.raster, self.frame))


def main() -> int:
    """Run the node."""
    return run(CoverageNode)


if __name__ == '__main__':
    sys.exit(main())
