"""The live map's page: where everybody is, was, and what happened."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from nicegui import app, ui
from nicegui.element import Element
from starlette.responses import FileResponse
from starlette.websockets import WebSocket

from mctrack_ros.site.plan import KINDS, FloorPlan
from mctrack_ros.web.live.backdrop import PLAN
from mctrack_ros.web.live.live_map import LiveMap

STYLES = (Path(__file__).parents[1] / 'pages.css', Path(__file__).with_name('live.css'))
SOCKET = '/live'
"""Address of the web socket; `frames` and `requests` say what goes through it."""


class MapElement(Element, component='map.js', esm={'mctrack-live': 'client'}):
    """The whole page: the map on a canvas, its controls and lists, drawn in the browser."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self._props.update(title=title, socket=SOCKET)


def add_pages(live_map: LiveMap, title: str, plan: FloorPlan | None) -> Callable[[], None]:
    """Add the addresses of the web socket and the floor plan; return what builds the page."""

    @app.websocket(SOCKET)
    async def _serve(socket: WebSocket) -> None:
        await live_map.serve(socket)

    if plan is not None:

        @app.get(PLAN)
        def _plan() -> FileResponse:
            return FileResponse(plan.path, media_type=KINDS[plan.path.suffix.lower()])

    app.on_shutdown(live_map.close)

    def page() -> None:
        for style in STYLES:
            ui.add_css(style.read_text())
        ui.dark_mode(True)
        MapElement(title)

    return page
