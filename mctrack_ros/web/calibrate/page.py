"""The calibration page: the event-tracking paper's TG-creator (section 4.4, Figure 10)."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from nicegui import Client, app, ui
from nicegui.events import KeyEventArguments
from numpy.typing import NDArray
from starlette.responses import Response

from mctrack_ros.ground import GridError
from mctrack_ros.web.board import Board
from mctrack_ros.web.calibrate.assessment import assessed, point_rows
from mctrack_ros.web.calibrate.pairing import Pairing, PairingError
from mctrack_ros.web.drawing import (
    ARROW_SCALE,
    image_drawing,
    plan_drawing,
    plan_extent,
)
from mctrack_ros.web.lines import grid_step
from mctrack_ros.web.steps import handler_of, pressed

STYLE = Path(__file__).parents[1] / 'pages.css'
IMAGE = '/image.png'
COLUMNS: list[dict[str, Any]] = [
    {'name': 'name', 'label': 'point', 'field': 'name', 'align': 'left', 'sortable': True},
    {'name': 'ground', 'label': 'ground [m]', 'field': 'ground', 'align': 'right'},
    {'name': 'pixel', 'label': 'image [px]', 'field': 'pixel', 'align': 'right'},
    {
        'name': 'residual',
        'label': 'off [px]',
        'field': 'residual',
        'align': 'right',
        'sortable': True,
        ':format': 'value => value === null ? "" : value.toFixed(2)',
    },
]


@dataclass(frozen=True, eq=False, slots=True)
class Desk:
    """What a page works on: the pairs, the image as PNG, and the file to write."""

    pairing: Pairing
    png: bytes
    out: Path


def desk(pairing: Pairing, image: NDArray[np.uint8], out: Path) -> Desk:
    """Return a desk for a (height, width, 3) image, blue, green, red."""
    _, png = cv2.imencode('.png', image)
    return Desk(pairing, png.tobytes(), out)


def add_pages(on: Desk) -> Callable[[], None]:
    """Add the image's address; return the function that builds the page."""
    views: list[_View] = []

    def refresh_all() -> None:
        for view in views:
            view.refresh()

    @app.get(IMAGE)
    def _image() -> Response:
        return Response(on.png, media_type='image/png', headers={'Cache-Control': 'no-store'})

    def page(client: Client) -> None:
        view = _View(on, refresh_all)
        views.append(view)
        client.on_delete(lambda: views.remove(view))

    return lambda: page(ui.context.client)


class _View:
    """The page in one browser window; all windows show the same pairs."""

    def __init__(self, on: Desk, changed: Callable[[], object]) -> None:
        self._pairing, self._out, self._changed = on.pairing, on.out, changed
        ui.add_css(STYLE.read_text())
        ui.dark_mode(True)
        ui.keyboard(self._key)
        with ui.element('div').classes('sheet'):
            self._build_bar()
            width, height = on.pairing.image_size
            with ui.element('div').classes('pane image'):
                ui.label(
                    f'arrows lead to where the camera sees the point, {ARROW_SCALE:g} x'
                ).classes('caption')
                self._image = Board(
                    (0.0, 0.0, float(width), float(height)),
                    self._do(self._pairing.place),
                    self._do(self._pairing.choose),
                    self._do(self._pairing.move),
                    IMAGE,
                )
            with ui.element('div').classes('side'):
                self._build_side()
        self.refresh()

    def refresh(self) -> None:
        """Show the pairs as they are."""
        pairing = self._pairing
        self._image.show(image_drawing(pairing), pairing.is_placing)
        self._plan.show(plan_drawing(pairing))
        self._undo.set_enabled(pairing.can_undo)
        self._redo.set_enabled(pairing.can_redo)
        self._delete.set_enabled(pairing.chosen in pairing.pairs)
        self._hint.set_text(_hint(pairing))
        self._table.rows = point_rows(pairing)
        found = assessed(pairing)
        self._verdict.classes(replace=f'verdict {found.kind}')
        self._verdict.set_content(
            f'<div class="headline">{html.escape(found.headline)}</div>'
            + ''.join(f'<div>{html.escape(line)}</div>' for line in found.details)
            + ''.join(f'<div class="warning">{html.escape(line)}</div>' for line in found.warnings)
        )

    def _build_bar(self) -> None:
        pairing = self._pairing
        with ui.element('div').classes('bar'):
            ui.label(f'Calibrate {pairing.camera}').classes('title')
            self._hint = ui.label().classes('hint')
            self._undo = ui.button('Undo', icon='undo', on_click=self._do(pairing.undo))
            self._redo = ui.button('Redo', icon='redo', on_click=self._do(pairing.redo))
            self._delete = ui.button('Delete', icon='delete', on_click=self._do(self._remove))
            whole = ui.button('Whole', icon='fit_screen')
            whole.on_click(self._show_all)
            for button in (self._undo, self._redo, self._delete, whole):
                button.props('flat no-caps dense color=white')
            save = ui.button('Save', icon='save', on_click=self._save)
            save.props('no-caps dense unelevated color=positive').classes('q-px-md')

    def _build_side(self) -> None:
        pairing = self._pairing
        with ui.element('div').classes('pane plan'):
            ui.label(f'the scene from above, lines {grid_step(pairing.ground):g} m apart').classes(
                'caption'
            )
            self._plan = Board(
                plan_extent(pairing),
                lambda x, y: None,
                self._do(pairing.choose),
                lambda name, x, y: None,
                unit='m',
            )
        self._verdict = ui.html('', sanitize=False)
        with ui.element('div').classes('pane'):
            self._table = ui.table(
                rows=[], columns=COLUMNS, row_key='name', pagination={'rowsPerPage': 0}
            )
            self._table.classes('numbers').props('dense flat hide-bottom')
            self._table.on('rowClick', lambda event: self._do(pairing.choose)(event.args['name']))

    def _do(self, step: Callable[..., object]) -> Callable[..., None]:
        return handler_of(step, PairingError, self._changed)

    def _show_all(self) -> None:
        self._image.show_all()
        self._plan.show_all()

    def _remove(self) -> None:
        self._pairing.delete(self._pairing.chosen)

    def _save(self) -> None:
        try:
            ignored = self._pairing.save(self._out)
        except (GridError, OSError) as error:
            ui.notify(f'Not saved: {error}', type='negative')
            return
        left_out = f'; left out, in no complete cell: {", ".join(ignored)}' if ignored else ''
        ui.notify(f'Saved {self._out}{left_out}', type='positive')

    def _key(self, event: KeyEventArguments) -> None:
        asked = pressed(event)
        if asked == 'redo':
            self._do(self._pairing.redo)()
        elif asked == 'undo':
            self._do(self._pairing.undo)()
        elif asked == 'delete' and self._pairing.chosen in self._pairing.pairs:
            self._do(self._remove)()
        elif asked == 'escape':
            self._do(self._pairing.forget)()


def _hint(pairing: Pairing) -> str:
    """Return what to do next."""
    if pairing.waiting is not None:
        return 'Now click its point on the plan (Esc: forget)'
    if pairing.is_placing:
        return f'Now click {pairing.chosen} in the image (wheel: zoom, Esc: forget)'
    if pairing.chosen:
        return f'{pairing.chosen}: drag it to mend, Delete to remove'
    return 'Click a point on the plan, then its place in the image; or the reverse'
