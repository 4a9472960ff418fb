"""Where people can stand, and what they cover there in each camera's mask."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.occupancy.config import PeopleConfig
from mctrack_ros.fusion.occupancy.solver import Places
from mctrack_ros.fusion.views import Views
from mctrack_ros.interfaces import ClassCode

if TYPE_CHECKING:
    from mctrack_ros.ground import GroundMapping
    from mctrack_ros.ground.coverage.field_of_view import Region

Floats = NDArray[np.float64]
Boxes = NDArray[np.int16]

LEAST_HEIGHT_PX = 16.0
"""Where a person would look smaller than this in every image, nobody is looked for, px."""
REACH_M = 0.45
"""How far a person moves in a round, m: three cells."""
LEAST_DISTANCE_M = 0.4
"""Between two people, m: 0.3 to 0.5 give the same on the four-camera terrace to frame 1250;
without, 2 switches more."""
MARGIN_M = 1.0
"""How far beyond the stated area people are looked for, m: who stands on its edge is not whole
within."""
MOST_CELLS = 60_000
"""Larger scenes have wider cells: with 8 cameras and 20 people these take 30 ms a tick."""
LEAST_PX_PER_M = 4.0
"""By so much a metre in any direction moves a person in the images, or nobody is looked
for: his place would be uncertain by more than a quarter of a metre, px/m."""
LEAST_SEEN = 0.3
"""Share of a person's box that must be in an image to be looked for there."""


class Scene:
    """
    The cells of a site.

    Parameters
    ----------
    views : Views
        How its cameras see the ground.
    cameras : tuple of str
        Their names in the site's order.
    config : PeopleConfig
        Distance of the cells, sizes of people.

    Attributes
    ----------
    position : (cells, 2) array
        Of the cells, m, row by row: y ascends.
    step : float
        Their distance, m.

    Raises
    ------
    ConfigError
        If no camera sees anybody anywhere.

    """

    class_id = ClassCode.UNKNOWN
    extent = (np.nan, np.nan)

    def __init__(self, views: Views, cameras: tuple[str, ...], config: PeopleConfig) -> None:
        self._config = config
        mappings = [views.mappings[name] for name in cameras]
        corners = bounds(mappings, views.area, config.person_height)
        self._lay_out(mappings, views.area, corners)
        if views.area is None:  # what is seen well is a small part of what is seen
            corners = np.stack([self.position.min(axis=0), self.position.max(axis=0)])
            self._lay_out(mappings, None, corners)
        self._sizes = [mapping.image_size for mapping in mappings]
        self._scaled: dict[tuple[tuple[int, int], ...], Places] = {}

    def shared(self) -> float:
        """Return the share of the cells that two cameras or more see."""
        return float((np.isfinite(self._box[..., 0]).sum(axis=0) >= 2).mean())

    def places(self, shapes: tuple[tuple[int, int], ...]) -> Places:
        """
        Return where people can be, and what they cover of masks there.

        Parameters
        ----------
        shapes : tuple of (int, int)
            Height and width of each camera's mask, px.

        """
        if shapes not in self._scaled:
            boxes = self._scale(shapes)
            first, none = np.zeros(boxes.shape[:2], np.int32), np.empty((0, 2), np.int16)
            places = Places(self.position, boxes, first, none, REACH_M, LEAST_DISTANCE_M)
            self._scaled = {shapes: places}
        return self._scaled[shapes]

    def _lay_out(
        self, mappings: list[GroundMapping], area: Region | None, corners: Floats
    ) -> None:
        """Lay out cells between two corners, m, where a person can be found and located."""
        self.position, self.step = lattice(corners, self._config.cell)
        if area is not None:
            near = shapely.buffer(area, MARGIN_M)
            self.position = self.position[shapely.contains_xy(near, *self.position.T)]
        self._box = np.stack([self._boxes(mapping) for mapping in mappings])
        kept = _resolution(mappings, self.position, self._box) >= LEAST_PX_PER_M
        if not kept.any():
            raise ConfigError('no camera sees a place of the area where a person is large enough')
        self.position = np.ascontiguousarray(self.position[kept])
        self._box = self._box[:, kept]

    def _boxes(self, mapping: GroundMapping) -> Floats:
        """Return the (cells, 4) boxes in a camera's images; NaN: not to be seen there."""
        foot = mapping.image_from_ground(self.position)
        head = mapping.image_from_ground(self.position, self._config.person_height)
        width = mapping.width_px(self.position, self._config.person_width)
        middle = (foot[:, 0] + head[:, 0]) / 2
        top, bottom = np.minimum(head[:, 1], foot[:, 1]), np.maximum(head[:, 1], foot[:, 1])
        box = np.column_stack([middle - width / 2, top, middle + width / 2, bottom])
        columns, rows = mapping.image_size
        with np.errstate(invalid='ignore', divide='ignore'):
            across = np.clip(box[:, 2], 0, columns) - np.clip(box[:, 0], 0, columns)
            down = np.clip(box[:, 3], 0, rows) - np.clip(box[:, 1], 0, rows)
            share = across * down / (width * (bottom - top))
            seen = (share >= LEAST_SEEN) & (bottom - top >= LEAST_HEIGHT_PX)
        box[~seen] = np.nan
        return box

    def _scale(self, shapes: tuple[tuple[int, int], ...]) -> Boxes:
        scaled = np.zeros(self._box.shape, np.int16)
        for camera, ((height, width), (columns, rows)) in enumerate(zip(shapes, self._sizes)):
            factor = np.array([width / columns, height / rows] * 2)
            edge = np.array([width, height] * 2)
            box = np.clip(np.rint(self._box[camera] * factor), 0, edge)
            is_empty = ~(np.diff(box.reshape(-1, 2, 2), axis=1) > 0).all(axis=(1, 2))
            box[is_empty] = 0
            scaled[camera] = box
        return scaled


def bounds(mappings: list[GroundMapping], area: Region | None, height: float) -> Floats:
    """Return the (2, 2) corners around all places where people are looked for, m."""
    if area is not None:
        beyond = np.array([[-MARGIN_M], [MARGIN_M]])
        return np.asarray(np.reshape(area.bounds, (2, 2)) + beyond)
    places = []
    for mapping in mappings:
        place = mapping.visible_ground()
        places.append(place[mapping.height_px(place, height) >= LEAST_HEIGHT_PX])
    every = np.concatenate(places)
    if not len(every):
        raise ConfigError('no camera sees ground where a person would be large enough to be found')
    return np.stack([every.min(axis=0) - MARGIN_M, every.max(axis=0) + MARGIN_M])


def _resolution(mappings: list[GroundMapping], position: Floats, box: Floats) -> Floats:
    """Return by how many pixels a metre moves a person at least, in all images, (n,) px/m."""
    information = np.zeros((len(position), 2, 2))
    for mapping, own in zip(mappings, box):
        seen = np.isfinite(own[:, 0])
        slopes = mapping.image_jacobian(position[seen])
        information[seen] += slopes.transpose(0, 2, 1) @ slopes
    least = np.linalg.eigvalsh(np.nan_to_num(information))[:, 0]
    return np.asarray(np.sqrt(np.maximum(least, 0.0)))


def lattice(corners: Floats, cell: float) -> tuple[Floats, float]:
    """Return points between two corners, (n, 2), about `MOST_CELLS` at most, and their step, m."""
    width, height = corners[1] - corners[0]
    step = max(cell, float(np.sqrt(width * height / MOST_CELLS)))
    x, y = (np.arange(low, high, step) for low, high in zip(*corners))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2), step
