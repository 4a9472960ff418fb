"""Connections of uvicorn's server, with the limits that hostile clients make necessary."""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.config import Config
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState
from websockets.extensions.permessage_deflate import ServerPerMessageDeflateFactory
from websockets.server import ServerProtocol

REQUEST_S = 5.0
"""Within so long after it has connected a client must have asked, s."""
LARGEST_REQUEST = 8192
"""Of a request line with its headers, bytes."""
LARGEST_MESSAGE = 1024
"""Most that a client may send over a web socket, bytes; it has nothing to say."""
CONNECTION = 'connection'
"""Under which name a request's state holds its connection."""


class HttpConnection(H11Protocol):
    """One client by HTTP: it must ask soon; uvicorn would wait for a request for ever."""

    def __init__(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, {**app_state, CONNECTION: self}, _loop)
        self._deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait."""
        super().connection_made(transport)
        self._deadline = self.loop.call_later(REQUEST_S, self._expire)

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no longer."""
        self._wait_no_longer()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over to a web socket, which has limits of its own."""
        self._wait_no_longer()
        super().handle_websocket_upgrade(event)

    def _expire(self) -> None:
        if self.cycle is None:
            self.transport.abort()

    def _wait_no_longer(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()


class SocketConnection(WebSocketsSansIOProtocol):
    """One client by web socket, compressed with a window that holds the frame before."""

    def __init__(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, {**app_state, CONNECTION: self}, _loop)
        deflate = ServerPerMessageDeflateFactory(client_max_window_bits=9)
        self.conn = ServerProtocol(
            extensions=[deflate], max_size=config.ws_max_size, logger=self.logger
        )
