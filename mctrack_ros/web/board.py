"""A drawing to click on, drag in, zoom and pan, in the browser."""

from __future__ import annotations

from collections.abc import Callable

from nicegui.element import Element

from mctrack_ros.ground.origin import local_origin
from mctrack_ros.web.drawing import Drawing
from mctrack_ros.web.lines import Extent


class Board(Element, component='board.js'):
    """
    Show a drawing over an image or a blank ground; report clicks and drags.

    Parameters
    ----------
    extent : (float, float, float, float)
        Left, top, width and height of what it shows at first, in the drawing's units.
    on_click : callable
        Given x and y of a click that meets no mark, or any while `show` says so.
    on_pick : callable
        Given the name of a mark that is clicked.
    on_move : callable
        Given the name of a mark and the x and y to which it was dragged.
    image : str
        Address of an image that fills the extent.
    unit : str
        Of the drawing's coordinates.

    """

    def __init__(
        self,
        extent: Extent,
        on_click: Callable[[float, float], None],
        on_pick: Callable[[str], None],
        on_move: Callable[[str, float, float], None],
        image: str = '',
        unit: str = 'px',
    ) -> None:
        super().__init__()
        # browsers draw in float32: far places are sent relative to one near by
        self._origin = x, y = local_origin(extent[:2]).tolist()
        self._props.update(extent=self._near(extent), unit=unit, placing=False)
        self._props.update(image=image, frame=self._near(extent), origin=[x, y])
        self.on('placed', lambda event: on_click(event.args['x'] + x, event.args['y'] + y))
        self.on('picked', lambda event: on_pick(event.args['name']))
        self.on('moved', lambda e: on_move(e.args['name'], e.args['x'] + x, e.args['y'] + y))

    def show(self, drawing: Drawing, placing: bool = False) -> None:
        """Show a drawing; while `placing`, marks do not catch clicks."""
        x, y = self._origin
        self._props.update(drawing=drawing.moved(-x, -y).as_json(), placing=placing)
        self.update()

    def show_image(self, image: str, frame: Extent) -> None:
        """Show another image, in a frame of its own."""
        self._props.update(image=image, frame=self._near(frame))
        self.update()

    def turn_to(self, image: str, extent: Extent) -> None:
        """Show another image that fills an extent of its own, and all of it."""
        self._props.update(extent=self._near(extent))
        self.show_image(image, extent)

    def _near(self, extent: Extent) -> list[float]:
        """Return an extent as the browser receives it."""
        (left, top, width, height), (x, y) = extent, self._origin
        return [left - x, top - y, width, height]

    def show_all(self) -> None:
        """Zoom out to the whole extent."""
        self.run_method('show_all')
