"""The live map's server: from the graph and the database to the windows that are open."""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from mctrack_ros.config import ConfigError
from mctrack_ros.interfaces import Events, Tracks
from mctrack_ros.store import StoreError
from mctrack_ros.web.live.browser import TAKEN, Browser
from mctrack_ros.web.live.event_lines import event_lines
from mctrack_ros.web.live.frames import image_message, tracks_message
from mctrack_ros.web.live.health import Health
from mctrack_ros.web.live.past import Past
from mctrack_ros.web.live.requests import At, Draw, Find, Live, RequestError, Show, request_from
from mctrack_ros.web.live.site_zones import SiteZones
from mctrack_ros.zones.shapes import Zones

if TYPE_CHECKING:
    from mctrack_ros.ros.topics.live_graph import CameraImage, LiveGraph, Status

MOST_BROWSERS = 16
"""Windows at a time."""
_TICK_S = 1.0
_LINGER_S = 5.0
"""How long the graph is listened to when nobody looks any more."""
_EVENTS = 100
"""Last events that a new window is told."""
_TOO_LONG, _TOO_MANY = 1009, 1013  # closing codes of web sockets, RFC 6455


class LiveMap:
    """
    Bring tracks, events, health and images to the windows.

    A message is encoded once, however many windows there are. The graph is joined when the first
    window opens, and left when the last one is closed.

    Parameters
    ----------
    ground : mapping
        What lies under the tracks: `backdrop`.
    listen : callable or None
        Joins the graph for a listener; None: there is only the past.
    past : Past or None
        The database.
    zones : SiteZones or None
        Of the site; None: none are shown.

    """

    def __init__(
        self,
        ground: Mapping[str, Any],
        listen: Callable[[LiveMap], LiveGraph] | None,
        past: Past | None,
        zones: SiteZones | None = None,
    ) -> None:
        self._listen, self._past, self._zones = listen, past, zones
        modes = {'live': listen is not None, 'editable': zones is not None}
        self._ground = json.dumps({'kind': 'ground', **ground, **modes})
        self._names = [camera['name'] for camera in ground['cameras']]
        self._health = Health(self._names)
        self._zone_names = _names(zones.described()) if zones else []
        self._browsers: set[Browser] = set()
        self._events: deque[dict[str, Any]] = deque(maxlen=_EVENTS)
        self._graph: LiveGraph | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ticking: asyncio.Task[None] | None = None
        self._asking = asyncio.Lock()
        self._newest: bytes | None = None
        self._sent: dict[str, str] = {}

    async def serve(self, socket: WebSocket) -> None:
        """Serve one window until it is closed."""
        await socket.accept()
        if len(self._browsers) >= MOST_BROWSERS:
            await socket.close(_TOO_MANY, 'too many windows show this map')
            return
        browser = Browser(socket)
        self._browsers.add(browser)
        self._begin(browser)
        sending = asyncio.create_task(browser.send())
        try:
            while True:
                text = await socket.receive_text()
                if text == TAKEN:
                    browser.taken()
                else:
                    await self._answer(browser, text)
        except (WebSocketDisconnect, RuntimeError, KeyError):
            pass  # closed, or bytes where text is expected
        finally:
            sending.cancel()
            self._browsers.discard(browser)
            self._follow_cameras()

    async def close(self) -> None:
        """Leave the graph and the database."""
        if self._ticking is not None:
            self._ticking.cancel()
        await self._leave()
        if self._past is not None:
            self._past.close()

    def heard_tracks(self, tracks: Tracks) -> None:
        """Take a message of `/tracks`, in the graph's thread."""
        was_waiting, self._newest = self._newest is not None, tracks_message(tracks)
        if not was_waiting:
            self._soon(self._offer)

    def heard_events(self, events: Events) -> None:
        """Take a message of `/events`, in the graph's thread."""
        lines = list(event_lines(events, self._zone_names))
        text = json.dumps({'kind': 'events', 'lines': lines})
        self._soon(self._happened, lines, text)

    def heard_site(self, description: Mapping[str, Any]) -> None:
        """Take what `/site` says, in the graph's thread."""
        try:
            self._zone_names = _names(description.get('zones', []))
            names = [str(name) for name in description.get('cameras', [])]
        except (KeyError, TypeError):  # somebody else's description
            return
        self._soon(self._described, names)

    def heard_health(self, statuses: list[Status]) -> None:
        """Take a message of `/diagnostics`, in the graph's thread."""
        self._soon(self._health.hear, statuses, time.monotonic())

    def received_image(self, image: CameraImage) -> None:
        """Take an image of a camera, in the graph's thread."""
        number = self._names.index(image.camera)
        message = image_message(number, image.stamp_ns, image.data, image.detections)
        self._soon(self._offer_image, image.camera, message)

    def _soon(self, call: Callable[..., None], *arguments: Any) -> None:
        """Call something in the loop's thread."""
        assert self._loop is not None
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(call, *arguments)

    def _begin(self, browser: Browser) -> None:
        self._loop = asyncio.get_running_loop()
        if self._ticking is None or self._ticking.done():
            self._ticking = asyncio.create_task(self._tick())
        browser.is_live = self._listen is not None
        browser.tell_text(self._ground)
        if self._zones is not None:
            browser.tell({'kind': 'zones', 'shapes': self._zones.described()})
        browser.tell({'kind': 'events', 'lines': list(self._events)})
        for text in self._sent.values():
            browser.tell_text(text)

    async def _tick(self) -> None:
        """Once a second, as long as there are windows: health, and how far the past goes."""
        alone_since: float | None = None
        while True:
            if self._browsers:
                alone_since = None
                if self._graph is None and self._listen is not None:
                    self._graph = await asyncio.to_thread(self._listen, self)
                    self._follow_cameras()
                await self._look_at_past()
                if self._listen is not None:
                    parts = self._health.report(time.monotonic())
                    self._tell_all('health', {'parts': parts})
            elif alone_since is None:
                alone_since = time.monotonic()
            elif time.monotonic() - alone_since > _LINGER_S:
                await self._leave()
                return
            await asyncio.sleep(_TICK_S)

    async def _leave(self) -> None:
        if self._graph is not None:
            graph, self._graph = self._graph, None
            await asyncio.to_thread(graph.close)
            self._sent.clear()

    async def _look_at_past(self) -> None:
        if self._past is None:
            return
        try:
            async with self._asking:
                extent = await asyncio.to_thread(self._past.extent)
        except StoreError as error:
            self._tell_all('past', {'text': str(error)})
        else:
            span = {'began': extent.began_s, 'ended': extent.ended_s}
            self._tell_all('past', {'run': extent.run, **span})

    async def _answer(self, browser: Browser, text: str) -> None:
        try:
            request = request_from(text)
            if isinstance(request, Live):
                browser.is_live = self._listen is not None
            elif isinstance(request, At):
                await self._show_past(browser, request.time_s)
            elif isinstance(request, Show):
                browser.cameras = request.cameras
                self._follow_cameras()
            elif isinstance(request, Find):
                await self._find(browser, request)
            elif isinstance(request, Draw):
                await self._save(browser, request.zones)
        except (ConfigError, RequestError, StoreError) as error:
            browser.tell({'kind': 'refused', 'text': str(error)})

    async def _show_past(self, browser: Browser, at_s: float) -> None:
        if self._past is None:
            raise RequestError('no database is shown: mctrack map --database')
        browser.is_live = False
        async with self._asking:
            block = await asyncio.to_thread(self._past.block, at_s)
        browser.tell({'kind': 'block', 'events': block.events})
        browser.offer(block.message)

    async def _find(self, browser: Browser, request: Find) -> None:
        found = None
        if self._past is not None:
            async with self._asking:
                found = await asyncio.to_thread(
                    self._past.last_seen, request.track, request.before_s
                )
        browser.tell({'kind': 'found', 'track': request.track, 'time': found})

    async def _save(self, browser: Browser, zones: Zones) -> None:
        if self._zones is None:
            raise RequestError('no site is shown: mctrack map SITE')
        text = await asyncio.to_thread(self._zones.save, zones)
        for each in self._browsers:
            each.tell({'kind': 'zones', 'shapes': self._zones.described()})
        browser.tell({'kind': 'saved', 'text': text})

    def _offer(self) -> None:
        frame, self._newest = self._newest, None
        if frame is not None:
            for browser in self._browsers:
                if browser.is_live:
                    browser.offer(frame)

    def _offer_image(self, camera: str, message: bytes) -> None:
        for browser in self._browsers:
            browser.offer_image(camera, message)

    def _happened(self, lines: Sequence[dict[str, Any]], text: str) -> None:
        self._events.extend(lines)
        for browser in self._browsers:
            browser.tell_text(text)

    def _described(self, names: Sequence[str]) -> None:
        """Take the cameras of a graph, in the order of their bits."""
        if not self._names:  # no site is known
            self._health.cameras = tuple(names)
        self._tell_all('cameras', {'names': list(names)})

    def _tell_all(self, kind: str, content: Mapping[str, Any]) -> None:
        """Tell every window what is not yet known to it, and those that come later."""
        text = json.dumps({'kind': kind, **content})
        if self._sent.get(kind) != text:
            self._sent[kind] = text
            for browser in self._browsers:
                browser.tell_text(text)

    def _follow_cameras(self) -> None:
        if self._graph is not None:
            self._graph.show(set().union(*(browser.cameras for browser in self._browsers)))


def _names(zones: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the names of zones and lines in the order of their indices."""
    return [str(each['name']) for each in zones]
