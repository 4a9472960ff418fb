"""Fields of view that are drawn, and what the cameras see together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mctrack_ros.ground.coverage.coverage import Coverage, CoverageConfig, coverage_of
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, Region, polygon_from
from mctrack_ros.ground.coverage.view import View
from mctrack_ros.web.coverage.corner_order import place_in_order
from mctrack_ros.web.history import History, Undoable

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

    @property
    def corners(self) -> Corners:
        """Corners of the chosen camera's field, m, as far as it is drawn."""
        return self._history.present.get(self.chosen, ())

    @property
    def view(self) -> View:
        """What the chosen camera sees by its calibration."""
        return self._views[self.chosen]

    @property
    def reach(self) -> float:
        """How far from its foot a camera is of use, m."""
        return self._config.reach

    def choose(self, name: str) -> None:
        """Choose the camera whose field is drawn."""
        if name not in self._views:
            raise FieldOfViewError(f'camera is {name!r}, expected one of {", ".join(self.names)}')
        self.chosen, self.corner = name, None

    def choose_corner(self, index: int) -> None:
        """Choose a corner of the chosen camera's field."""
        self.corners[index]
        self.corner = index

    def add(self, x: float, y: float, index: int | None = None) -> None:
        """
        Add a corner to the chosen camera's field.

        Parameters
        ----------
        x, y : float
            Where, m.
        index : int, optional
            Its place in their order; by default `place_in_order` on the ground.

        """
        corners = list(self.corners)
        corners.insert(
            place_in_order(corners, (x, y)) if index is None else index,
            (round(x, 3), round(y, 3)),
        )
        self._put(tuple(corners))

    def move(self, index: int, x: float, y: float) -> None:
        """Put a corner of the chosen camera's field elsewhere, m."""
        corners = list(self.corners)
        corners[index] = (round(x, 3), round(y, 3))
        self._put(tuple(corners))

    def delete(self, index: int) -> None:
        """Remove a corner of the chosen camera's field."""
        corners = list(self.corners)
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
