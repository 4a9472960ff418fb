"""A site of 120 x 80 m with a hundred cameras in cells, and people who walk about it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.synthetic_cameras import KITS
from mctrack_experiments.bench.fusion.toolkit import Scene
from mctrack_experiments.scenarios.rooms import PERSONAL
from mctrack_experiments.scenarios.staged import stage
from mctrack_experiments.scenarios.staged.stage import Stage, View, hidden_in, scene_of
from mctrack_experiments.scenarios.staged.walks import walk

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

GRID = (10, 10)
"""Cameras along x and y."""
SPACING_M, FIELD_M = (12.0, 8.0), (18.0, 12.0)
"""From camera to camera, and what each sees: cells overlap by 6 m along x and by 4 m along y."""
STANDS_M = 8.0
"""How far before the middle of its field a camera stands, m."""
GAP_M = 2.0
"""Width of the strip along the first border across x, which no camera sees, m."""
CELLS = {4: (2, 2), 6: (3, 2), 8: (4, 2)}
"""Cells along x and y, by their number."""
CELL_BIAS_M = 0.15
"""Standard deviation, along each axis, of what all cameras of a cell are off by, m."""
PEOPLE, SECONDS = 80, 44.0
TICK_S = 2 * stage.TICK_S
"""Of the cameras, s."""
SPEED_M_S, LEAST_WAY_M = (1.1, 1.7), 20.0


@dataclass(frozen=True, eq=False, slots=True)
class CellSite:
    """
    Who walks where, before the cameras of which cell.

    Attributes
    ----------
    paths : (ticks, people, 2) array
        Where everybody is, m.
    kit : (people + 1,) int array
        Who is dressed alike; the last one lends false detections his colours.
    scenes : list of Scene
        What the cameras of each cell detect.
    borders : pair of (k,) arrays
        Where the cells end along x and along y, m.

    """

    paths: Floats
    kit: Indices
    scenes: list[Scene]
    borders: tuple[Floats, Floats]

    def cell_of(self, place: Floats) -> Indices:
        """Return in whose ground (..., 2) places are."""
        across, along = (
            np.searchsorted(border, place[..., axis]) for axis, border in enumerate(self.borders)
        )
        return np.asarray(along * (len(self.borders[0]) + 1) + across)


def cell_site(seed: int, cells: int) -> CellSite:
    """Make a site of so many cells."""
    rng = np.random.default_rng([seed, 51])
    shape = CELLS[cells]
    edges = [
        np.round(np.arange(1, count) * number / count) * spacing
        for count, number, spacing in zip(shape, GRID, SPACING_M)
    ]
    paths = np.stack([_walk(rng) for _ in range(PEOPLE)], axis=1)
    kit = np.arange(PEOPLE) % KITS
    site = CellSite(paths, np.append(kit, KITS - 1), [], (edges[0], edges[1]))
    for cell, views in enumerate(_views(site, cells)):
        hidden = hidden_in(paths, (), len(views))
        shown = Stage(paths, kit, views, hidden, PERSONAL)
        scene = scene_of(shown, np.random.default_rng([seed, 52, cell]))
        off = rng.normal(0.0, CELL_BIAS_M, 2)
        fields = dict(scene.fields)
        fields['detection_position'] = fields['detection_position'] + off
        site.scenes.append(Scene(replace(scene.scenario, tick_s=TICK_S), fields))
    return site


def _views(site: CellSite, cells: int) -> list[list[View]]:
    """Return the cameras of each cell; at the first border across x they end before a strip."""
    views: list[list[View]] = [[] for _ in range(cells)]
    half, gap = np.array(FIELD_M) / 2, float(site.borders[0][0])
    for row in range(GRID[1]):
        for column in range(GRID[0]):
            middle = (np.array([column, row]) + 0.5) * SPACING_M
            low, high = middle - half, middle + half
            if middle[0] < gap:
                high[0] = min(high[0], gap - GAP_M / 2)
            else:
                low[0] = max(low[0], gap + GAP_M / 2)
            x, y = middle.tolist()
            field = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
            views[int(site.cell_of(middle))].append(View((x, y - STANDS_M), field))
    return views


def _walk(rng: np.random.Generator) -> Floats:
    """Return the places of one who goes from place to place of the site, (ticks, 2) m."""
    sides, when = np.array(GRID) * SPACING_M, 0.0
    place = rng.uniform(1.0, sides - 1.0)
    stops = [(0.0, *place.tolist())]
    while when < SECONDS:
        goal = rng.uniform(1.0, sides - 1.0)
        way = float(np.linalg.norm(goal - place))
        if way < LEAST_WAY_M:
            continue
        when, place = when + way / rng.uniform(*SPEED_M_S), goal
        stops.append((when, *goal.tolist()))
    return walk(stops, SECONDS, rng)[::2]
