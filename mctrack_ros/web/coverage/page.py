"""The coverage page: the event-tracking paper's coverage tool (section 4.4, Figure 13)."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from pathlib import Path

from nicegui import ui
from nicegui.events import KeyEventArguments

from mctrack_ros.ground import CalibrationError
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.web.board import Board
from mctrack_ros.web.coverage.drawing import MAPS, coverage_map, fields_drawing, fields_extent
from mctrack_ros.web.coverage.fields import Fields
from mctrack_ros.web.coverage.report import coverage_text, field_rows
from mctrack_ros.web.coverage.seen_pane import SeenPane, add_images
from mctrack_ros.web.image_source import Image
from mctrack_ros.web.steps import handler_of, pressed

STYLE = Path(__file__).parents[1] / 'pages.css'
COLUMNS = [
    {'name': 'camera', 'label': 'camera', 'field': 'camera', 'align': 'left'},
    {'name': 'field', 'label': 'field', 'field': 'field', 'align': 'left'},
    {'name': 'sees', 'label': 'sees [m²]', 'field': 'sees', 'align': 'right'},
    {'name': 'share', 'label': 'of the area', 'field': 'share', 'align': 'right'},
]


def coverage_page(
    fields: Fields, title: str, save: Callable[[], str], images: Mapping[str, Image]
) -> Callable[[], None]:
    """
    Return the function that builds the page.

    Parameters
    ----------
    fields : Fields
        What is drawn; all windows show the same.
    title : str
        Above the page.
    save : callable
        Writes the drawn fields and says where.
    images : mapping of str to (height, width, 3) uint8 array
        By camera, to draw on; if there are none, fields are drawn on the ground alone.

    """
    addresses = add_images(images)
    views: list[_View] = []

    def refresh_all() -> None:
        for view in views:
            view.refresh()

    def page() -> None:
        view = _View(fields, title, save, addresses, refresh_all)
        views.append(view)
        ui.context.client.on_delete(lambda: views.remove(view))

    return page


class _View:
    """The page in one browser window."""

    def __init__(
        self,
        fields: Fields,
        title: str,
        save: Callable[[], str],
        addresses: Mapping[str, str],
        changed: Callable[[], None],
    ) -> None:
        self._fields, self._write, self._changed = fields, save, changed
        ui.add_css(STYLE.read_text())
        ui.dark_mode(True)
        ui.keyboard(self._key)
        with ui.element('div').classes('sheet'):
            self._build_bar(title)
            with ui.element('div').classes('views'):
                self._seen = (
                    SeenPane(fields, addresses, self._do, self._pick) if addresses else None
                )
                self._build_ground()
            with ui.element('div').classes('side'):
                self._build_side()
        self.refresh()

    def refresh(self) -> None:
        """Show the fields as they are."""
        fields = self._fields
        self._cameras.set_value(fields.chosen)
        self._undo.set_enabled(fields.can_undo)
        self._redo.set_enabled(fields.can_redo)
        self._clear.set_enabled(fields.chosen in fields.drawn)
        self._board.show(fields_drawing(fields))
        if self._seen is not None:
            self._seen.refresh()
        self._show_map()
        self._table.rows = field_rows(fields)
        self._verdict.set_content(coverage_text(fields))
        self._verdict.classes(replace='verdict ' + ('bad' if fields.coverage.blind else 'good'))

    def _build_bar(self, title: str) -> None:
        fields = self._fields
        with ui.element('div').classes('bar'):
            ui.label(title).classes('title')
            ui.label('Click the corners around a field; drag one to mend it').classes('hint')
            self._undo = ui.button('Undo', icon='undo', on_click=self._do(fields.undo))
            self._redo = ui.button('Redo', icon='redo', on_click=self._do(fields.redo))
            self._clear = ui.button('Clear', icon='delete', on_click=self._do(fields.clear))
            whole = ui.button('Whole', icon='fit_screen', on_click=self._show_all)
            for button in (self._undo, self._redo, self._clear, whole):
                button.props('flat no-caps dense color=white')
            store = ui.button('Save', icon='save', on_click=self._save)
            store.props('no-caps dense unelevated color=positive').classes('q-px-md')

    def _build_ground(self) -> None:
        fields = self._fields
        with ui.element('div').classes('pane ground'):
            ui.label('the ground from above').classes('caption')
            self._board = Board(
                fields_extent(fields.coverage),
                self._do(lambda x, y: fields.add(x, -y)),
                self._do(self._pick),
                self._do(lambda name, x, y: fields.move(int(name), x, -y)),
                unit='m',
            )

    def _build_side(self) -> None:
        with ui.element('div').classes('choices'):
            ui.label('draw the field of')
            self._cameras = ui.toggle(
                list(self._fields.names),
                value=self._fields.chosen,
                on_change=lambda event: self._choose(event.value),
            ).props('no-caps dense')
            ui.label('show')
            self._map = ui.toggle(MAPS, value='cameras', on_change=lambda: self._show_map())
            self._map.props('no-caps dense')
            self._legend = ui.html('', sanitize=False)
        self._verdict = ui.html('', sanitize=False)
        with ui.element('div').classes('pane'):
            self._table = ui.table(
                rows=[], columns=COLUMNS, row_key='camera', pagination={'rowsPerPage': 0}
            )
            self._table.classes('numbers').props('dense flat hide-bottom')

    def _show_all(self) -> None:
        self._board.show_all()
        if self._seen is not None:
            self._seen.show_all()

    def _show_map(self) -> None:
        kind = str(self._map.value)
        found = coverage_map(self._fields.coverage, kind)
        image = base64.b64encode(found.png).decode()
        self._board.show_image(f'data:image/png;base64,{image}', found.frame)
        self._legend.set_content(
            f'<div class="legend">{found.least}<span class="scale {kind}"></span>'
            f'{found.most}</div>'
        )

    def _choose(self, name: str) -> None:
        if name != self._fields.chosen:
            self._do(self._fields.choose)(name)

    def _pick(self, name: str) -> None:
        """Choose the corner, or the camera, whose mark is clicked."""
        if name in self._fields.names:
            self._fields.choose(name)
        else:
            self._fields.choose_corner(int(name))

    def _do(self, step: Callable[..., object]) -> Callable[..., None]:
        return handler_of(step, FieldOfViewError, self._changed)

    def _save(self) -> None:
        try:
            ui.notify(self._write(), type='positive')
        except (CalibrationError, FieldOfViewError, OSError) as error:
            ui.notify(f'Not saved: {error}', type='negative')

    def _key(self, event: KeyEventArguments) -> None:
        asked = pressed(event)
        if asked == 'redo':
            self._do(self._fields.redo)()
        elif asked == 'undo':
            self._do(self._fields.undo)()
        elif asked == 'delete' and self._fields.corner is not None:
            self._do(self._fields.delete)(self._fields.corner)
