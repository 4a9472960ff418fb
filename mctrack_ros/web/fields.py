"""Fields of view drawn on the ground, and what the cameras see together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.coverage import Coverage, CoverageConfig, coverage_of
from mctrack_ros.ground.coverage_view import View
from mctrack_ros.ground.field_of_view import FieldOfViewError, Region, polygon_from
from mctrack_ros.web.history import History, Undoable

Floats = NDArray[np.float64]
Corner = tuple[float, float]
Corners = tuple[Corner, ...]
Drawn = Mapping[str, Corners]


class Fields(Undoable[Drawn]):
    """
    The coverage tool's state (event-tracking paper, section 4.4, Figure 13).

    A camera whose field of view is not drawn, or not yet a polygon, sees what `views` says.

    Parameters
    ----------
    views : mapping of str to View
        What each camera sees by its calibration.
    drawn : mapping of str to sequence of (float, float)
        Corners of the fields that are drawn already, m.
    area : Polygon or MultiPolygon, optional
        What is to be covered; by default the rectangle around all that is seen at first.
    config : CoverageConfig, optional
        Cells of the error map.

    Attributes
    ----------
    chosen : str
        The camera whose field is drawn.
    corner : int or None
        The corner of it that is chosen.
    coverage : Coverage
        What the cameras see now.

    """

    def __init__(
        self,
        views: Mapping[str, View],
        drawn: Drawn,
        area: Region | None = None,
        config: CoverageConfig | None = None,
    ) -> None:
        self._views, self._config = dict(views), config or CoverageConfig()
        self._history: History[Drawn] = History(dict(drawn))
        self.names = tuple(views)
        self.chosen = self.names[0]
        self.corner: int | None = None
        self.coverage: Coverage = coverage_of(self._seen(), area, self._config)

    @property
    def drawn(self) -> dict[str, Corners]:
        """Corners by camera, m, of the fields that are drawn."""
        return dict(self._history.present)

    def choose(self, name: str) -> None:
        """Choose the camera whose field is drawn."""
        if name not in self._views:
            raise FieldOfViewError(f'camera is {name!r}, expected one of {", ".join(self.names)}')
        self.chosen, self.corner = name, None

    def choose_corner(self, index: int) -> None:
        """Choose a corner of the chosen camera's field."""
        self._corners()[index]
        self.corner = index

    def add(self, x: float, y: float) -> None:
        """Add a corner, m, to the chosen camera's field: into the edge that it is nearest to."""
        corners = list(self._corners())
        corners.insert(_edge(corners, (x, y)) + 1, (round(x, 3), round(y, 3)))
        self._put(tuple(corners))

    def move(self, index: int, x: float, y: float) -> None:
        """Put a corner of the chosen camera's field elsewhere, m."""
        corners = list(self._corners())
        corners[index] = (round(x, 3), round(y, 3))
        self._put(tuple(corners))

    def delete(self, index: int) -> None:
        """Remove a corner of the chosen camera's field."""
        corners = list(self._corners())
        del corners[index]
        self._put(tuple(corners))

    def clear(self) -> None:
        """Remove the drawn field of the chosen camera: what its calibration says counts again."""
        self._put(())

    def flaws(self) -> dict[str, str]:
        """Say by camera why what is drawn is no field of view."""
        found = {}
        for name, corners in self._history.present.items():
            try:
                polygon_from(corners, f'the field of {name}')
            except FieldOfViewError as error:
                found[name] = str(error)
        return found

    def _corners(self) -> Corners:
        return self._history.present.get(self.chosen, ())

    def _put(self, corners: Corners) -> None:
        drawn = {**self._history.present, self.chosen: corners}
        self._history.step({name: found for name, found in drawn.items() if found})
        self._changed()

    def _changed(self) -> None:
        self.corner = None
        self.coverage = coverage_of(self._seen(), self.coverage.area, self._config)

    def _seen(self) -> dict[str, View]:
        """Return the views with the fields that are drawn in place of their own."""
        flawed, views = self.flaws(), dict(self._views)
        for name, corners in self._history.present.items():
            if name not in flawed:
                views[name] = replace(views[name], field=polygon_from(corners))
        return views


def _edge(corners: list[Corner], place: Corner) -> int:
    """Return the index of the edge, from that corner to the next, that a place is nearest to."""
    if len(corners) < 3:
        return len(corners) - 1
    start = np.array(corners)
    along = np.roll(start, -1, axis=0) - start
    away = np.array(place) - start
    square = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip((away * along).sum(axis=1) / square, 0, 1)
    return int(np.linalg.norm(away - share[:, None] * along, axis=1).argmin())
