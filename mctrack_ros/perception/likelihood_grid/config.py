"""Parameters of the likelihood-grid paper's camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from mctrack_ros.config import parameter, tag
from mctrack_ros.perception.background.model import BackgroundConfig
from mctrack_ros.perception.camera_shift.monitor import CameraShiftConfig
from mctrack_ros.perception.config import CameraConfig
from mctrack_ros.perception.likelihood_grid.contours import SHAPES


@dataclass(frozen=True)
class GridConfig:
    """Where people are looked for, and how large they are."""

    area: str = parameter(
        '',
        'x0,y0,x1,y1 of the grid, relative to the origin; a site fills in the corners of its own '
        'area [m]',
    )
    cells: int = parameter(
        40, 'cells of the finest grid along each side; a multiple of 4', minimum=4, maximum=400
    )
    person_height: float = parameter(
        1.75, 'height of the cylinder that stands for a person [m]', minimum=0.1, maximum=10.0
    )
    person_width: float = parameter(0.4, 'its width [m]', minimum=0.05, maximum=10.0)
    shape: str = parameter(
        'cylinder',
        'what stands in a cell: cylinder, as in the paper, person (a narrower head) or ellipsoid '
        '(what flies or rolls)',
        choices=tuple(SHAPES),
    )


@dataclass(frozen=True)
class LikelihoodCameraConfig(CameraConfig):
    """Parameters of `LikelihoodCamera`."""

    local_tracker: str = tag('likelihood_grid')
    grid: GridConfig = GridConfig()
    foreground: bool = parameter(
        True,
        'also send the foreground mask, for fusion.layers both; false: edges alone, as the paper',
    )
    background: BackgroundConfig = BackgroundConfig()
    camera_shift: CameraShiftConfig = CameraShiftConfig()

    def within(self, area: str) -> Self:
        """Return the parameters with the site's area, unless they name an own one."""
        return self if self.grid.area else replace(self, grid=replace(self.grid, area=area))
