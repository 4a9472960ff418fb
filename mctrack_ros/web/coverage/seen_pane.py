"""The pane in which the chosen camera's field of view is drawn on its image."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import cv2
from nicegui import app, ui
from starlette.responses import Response

from mctrack_ros.web.board import Board
from mctrack_ros.web.coverage.fields import Fields
from mctrack_ros.web.coverage.seen_drawing import image_extent, seen_drawing
from mctrack_ros.web.coverage.seen_field import add_seen, mapping_of, move_seen
from mctrack_ros.web.image_source import Image

Step = Callable[..., object]


def add_images(images: Mapping[str, Image]) -> dict[str, str]:
    """Serve a (height, width, 3) image a camera; return their addresses."""
    addresses = {}
    for name, image in images.items():
        addresses[name] = f'/image/{name}.png'
        _serve(addresses[name], cv2.imencode('.png', image)[1].tobytes())
    return addresses


def _serve(address: str, png: bytes) -> None:
    @app.get(address)
    def _image() -> Response:
        return Response(png, media_type='image/png', headers={'Cache-Control': 'no-store'})


class SeenPane:
    """
    A board with the chosen camera's image.

    Parameters
    ----------
    fields : Fields
        What is drawn.
    addresses : mapping of str to str
        Of the cameras' images; a camera that is not in it shows a metre grid alone.
    handled : callable
        Makes a handler of a step, as `handler_of` does.
    pick : callable
        Given the name of a mark that is clicked.

    """

    def __init__(
        self,
        fields: Fields,
        addresses: Mapping[str, str],
        handled: Callable[[Step], Callable[..., None]],
        pick: Callable[[str], None],
    ) -> None:
        self._fields, self._addresses = fields, addresses
        self._shown = fields.chosen
        with ui.element('div').classes('pane image'):
            self._caption = ui.label().classes('caption')
            self._board = Board(
                image_extent(mapping_of(fields)),
                handled(lambda x, y: add_seen(fields, x, y)),
                handled(pick),
                handled(lambda name, x, y: move_seen(fields, int(name), x, y)),
                self._address,
            )

    @property
    def _address(self) -> str:
        return self._addresses.get(self._fields.chosen, '')

    def refresh(self) -> None:
        """Show the chosen camera and its field as it is."""
        fields = self._fields
        if fields.chosen != self._shown:
            self._shown = fields.chosen
            self._board.turn_to(self._address, image_extent(mapping_of(fields)))
        without = '' if self._address else ' (no image: name a --source)'
        self._caption.set_text(
            f'seen by {fields.chosen}{without}; dashed: {fields.reach:g} m away, click below it'
        )
        self._board.show(seen_drawing(fields))

    def show_all(self) -> None:
        """Zoom out to the whole image."""
        self._board.show_all()
