"""One window that shows the map: what it is sent, and no faster than it takes it."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from typing import Any

from starlette.websockets import WebSocket

MOST_IN_FLIGHT = 2
"""Frames and images that are on their way to a window before it has said that it has them."""
_MOST_TEXTS = 200
TAKEN = 'a'
"""What a window says for each frame and image."""


class Browser:
    """
    A window.

    Of frames only the newest waits, and of images the newest of each camera: a slow window leaves
    out, and nothing queues.

    Parameters
    ----------
    socket : WebSocket
        Accepted.

    Attributes
    ----------
    is_live : bool
        Whether it shows what happens, not the past.
    cameras : frozenset of str
        Whose images it shows.

    """

    def __init__(self, socket: WebSocket) -> None:
        self.socket = socket
        self.is_live = True
        self.cameras: frozenset[str] = frozenset()
        self._in_flight = 0
        self._texts: deque[str] = deque(maxlen=_MOST_TEXTS)
        self._frame: bytes | None = None
        self._images: dict[str, bytes] = {}
        self._wake = asyncio.Event()

    def tell(self, content: dict[str, Any]) -> None:
        """Send something that is not to be left out."""
        self.tell_text(json.dumps(content))

    def tell_text(self, text: str) -> None:
        """Send the same, already as text."""
        self._texts.append(text)
        self._wake.set()

    def offer(self, frame: bytes) -> None:
        """Send a frame, unless a newer one comes before it can be sent."""
        self._frame = frame
        self._wake.set()

    def offer_image(self, camera: str, image: bytes) -> None:
        """Send an image, unless a newer one of its camera comes before."""
        if self.is_live and camera in self.cameras:
            self._images[camera] = image
            self._wake.set()

    def taken(self) -> None:
        """Note that a frame or an image has arrived."""
        self._in_flight = max(0, self._in_flight - 1)
        self._wake.set()

    async def send(self) -> None:
        """Send what there is, for ever."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._texts:
                await self.socket.send_text(self._texts.popleft())
            while self._in_flight < MOST_IN_FLIGHT and (message := self._next()):
                self._in_flight += 1
                await self.socket.send_bytes(message)

    def _next(self) -> bytes | None:
        if self._frame is not None:
            frame, self._frame = self._frame, None
            return frame
        return self._images.pop(next(iter(self._images))) if self._images else None
