"""The stream over HTTP and web sockets, read-only, in a thread of its own."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from dataclasses import dataclass

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.cors import CORSMiddleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route, WebSocketRoute
from starlette.types import Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn import Config, Server

from mctrack_ros.recording.closing import Closing
from mctrack_ros.streams.formats.text import since_ns
from mctrack_ros.streams.serve.access import Access, BearerGuard, check_address
from mctrack_ros.streams.serve.connections import (
    CONNECTION,
    LARGEST_MESSAGE,
    LARGEST_REQUEST,
    HttpConnection,
    SocketConnection,
)
from mctrack_ros.streams.serve.hub import Hub, Reader
from mctrack_ros.streams.serve.packing import GzipWriter

_ASKING = 64
"""Connections beyond those that read, which ask or are refused."""
_BACKLOG = 64
_ACCEPT_S = 0.02
"""Between two connections, s: who comes again and again must not take much of the processor."""
_SEND_BUFFER = 65536
"""Of a connection in the kernel, bytes: some seconds that nobody has read."""
_UNREAD_MS = 10_000
"""After so long without room for what it was sent the kernel gives a connection up, ms."""
_START_S, _END_S = 30.0, 5.0
_AGAIN_S = '5'


@dataclass(frozen=True, slots=True)
class Place:
    """
    Where a stream is served, and to whom.

    Attributes
    ----------
    host, port : str, int
        Where it is bound; 0: any free port.
    token : str
        What readers bring in the header ``Authorization: Bearer``; needed unless the host is this
        machine's loopback.
    origins : tuple of str
        Other sites whose pages may read.

    """

    host: str = '127.0.0.1'
    port: int = 0
    token: str = ''
    origins: tuple[str, ...] = ()


class StreamServer(Closing):
    """
    Serve the forms of a hub until it is closed.

    Parameters
    ----------
    hub : Hub
        What is read.
    place : Place
        Where, and to whom.
    most_readers : int
        How many may read at once.

    Raises
    ------
    ValueError
        If other machines reach the host and there is no token.
    OSError
        If the port is taken.

    """

    def __init__(self, hub: Hub, place: Place, most_readers: int) -> None:
        check_address(place.host, place.token, 'a token (MCTRACK_STREAM_TOKEN or token_file)')
        self._hub = hub
        self._socket = _listening(place)
        self.port: int = self._socket.getsockname()[1]
        self._most_connections = most_readers + _ASKING
        config = Config(
            _application(hub, place),
            http=HttpConnection,
            ws=SocketConnection,
            ws_max_size=LARGEST_MESSAGE,
            h11_max_incomplete_event_size=LARGEST_REQUEST,
            timeout_keep_alive=1,
            timeout_graceful_shutdown=2,
            lifespan='off',
            log_config=None,
            log_level='critical',
            access_log=False,
            proxy_headers=False,
            server_header=False,
        )
        self._config, self._server = config, Server(config)
        self._thread = threading.Thread(target=self._run, name='stream server', daemon=True)

    @property
    def connections(self) -> int:
        """How many are connected."""
        return len(self._server.server_state.connections)

    def start(self) -> None:
        """Begin to serve; return when clients may connect."""
        self._begun = threading.Event()
        self._thread.start()
        if not self._begun.wait(_START_S):
            raise RuntimeError('the stream server did not start')

    def close(self) -> None:
        """End all streams and the thread."""
        self._server.should_exit = True
        if self._thread.is_alive():
            self.loop.call_soon_threadsafe(self._hub.end)
            self._thread.join(_END_S)
        self._socket.close()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=self._server.config.get_loop_factory()) as runner:
            runner.run(self._serve())

    async def _serve(self) -> None:
        self.loop = asyncio.get_running_loop()
        self._hub.open(self.loop)
        serving = asyncio.create_task(self._server.serve(sockets=[]))
        accepting = asyncio.create_task(self._accept())
        self._begun.set()
        await serving
        accepting.cancel()

    async def _accept(self) -> None:
        """
        Accept one connection after the other, so many a second at most.

        The kernel keeps others waiting, and those who come by the thousand find no place there.

        """
        while True:
            with suppress(OSError):  # who has gone again, or there are no file descriptors
                connection, _ = await self.loop.sock_accept(self._socket)
                if self.connections < self._most_connections:
                    await self.loop.connect_accepted_socket(self._connection, connection)
                else:
                    connection.close()
            await asyncio.sleep(_ACCEPT_S)

    def _connection(self) -> HttpConnection:
        return HttpConnection(self._config, self._server.server_state, {}, self.loop)


def _listening(place: Place) -> socket.socket:
    """Return a socket whose connections hold little that was not read."""
    family = socket.AF_INET6 if ':' in place.host else socket.AF_INET
    listening = socket.socket(family)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNREAD_MS)
        listening.bind((place.host, place.port))
        listening.listen(_BACKLOG)
        listening.setblocking(False)
    except OSError as error:
        listening.close()
        raise OSError(f'{place.host}:{place.port} cannot be used: {error.strerror}') from error
    return listening


def _application(hub: Hub, place: Place) -> Starlette:
    access = Access(place.host, place.token, place.origins)
    middleware = [Middleware(BearerGuard, access=access)]
    if place.origins:  # before the guard: a browser asks without the token whether it may ask
        cross = Middleware(
            CORSMiddleware, allow_origins=list(place.origins), allow_headers=['Authorization']
        )
        middleware.insert(0, cross)
    streams = _Streams(hub)
    routes: list[Route | WebSocketRoute] = [Route('/', streams.contents)]
    for name in hub.profiles:
        routes += [Route(f'/{name}', streams.http), WebSocketRoute(f'/{name}', streams.socket)]
    return Starlette(routes=routes, middleware=middleware)


class _Streams:
    """What is answered."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub

    async def contents(self, request: Request) -> Response:
        """Say what may be read."""
        lines = ''.join(f'/{name}\n' for name in self._hub.profiles)
        return _answer(lines, 200)

    async def http(self, request: Request) -> Response:
        """Stream without an end."""
        profile = self._hub.profiles[request.url.path[1:]]
        if (
            'transfer-encoding' in request.headers
            or request.headers.get('content-length', '0') != '0'
        ):
            return _answer('A request has no body here.', 413)
        try:
            since = _since(request)
        except ValueError as error:
            return _answer(str(error), 400)
        headers = {'connection': 'close', 'cache-control': 'no-store', 'vary': 'accept-encoding'}
        packs = _takes_gzip(request.headers.get('accept-encoding', ''))
        if packs:
            headers['content-encoding'] = 'gzip'
        if request.method == 'HEAD':
            return Response(headers=headers, media_type=profile.media_type)
        await self._hub.described()
        if self._hub.is_full:
            return _answer('Too many read: try again later.', 503)
        reader = self._hub.join(profile, request.scope['state'][CONNECTION].transport.abort)
        body = self._body(reader, since, packs)
        return _Stream(body, headers, profile.media_type, lambda: self._hub.leave(reader))

    async def _body(self, reader: Reader, since: int | None, packs: bool) -> AsyncIterator[bytes]:
        head, tail = reader.profile.head(reader.about).encode(), reader.profile.tail.encode()
        writer = GzipWriter()
        yield writer.begin(head) if packs else head
        async for block in self._hub.read(reader, since):
            yield writer.write(block) if packs else block.text
        yield writer.end(tail) if packs else tail

    async def socket(self, socket: WebSocket) -> None:
        """Send a message a frame."""
        profile = self._hub.profiles[socket.url.path[1:]]
        try:
            since = _since(socket)
        except ValueError:
            await socket.close(1008)
            return
        await self._hub.described()
        if self._hub.is_full:
            await socket.close(1013)
            return
        transport = socket.scope['state'][CONNECTION].transport
        reader = self._hub.join(profile, transport.abort)
        try:
            await socket.accept()
            sending = asyncio.create_task(self._send(socket, reader, since))
            hearing = asyncio.create_task(socket.receive())
            done, rest = await asyncio.wait(
                {sending, hearing}, return_when=asyncio.FIRST_COMPLETED
            )
            for task in rest:
                task.cancel()
            await asyncio.gather(*rest, return_exceptions=True)
            if sending in done and sending.exception() is None:
                await socket.close(1001)
            elif hearing in done and hearing.result()['type'] == 'websocket.receive':
                transport.abort()  # it has nothing to say
        except WebSocketDisconnect:
            pass
        finally:
            self._hub.leave(reader)

    async def _send(self, socket: WebSocket, reader: Reader, since: int | None) -> None:
        head = reader.profile.head(reader.about)
        if not reader.profile.wraps:
            await socket.send_text(head)
        async for block in self._hub.read(reader, since):
            await socket.send_text(reader.profile.message(head, block.text.decode()))


class _Stream(StreamingResponse):
    """A response after which somebody is told, however it ends."""

    def __init__(
        self,
        body: AsyncIterator[bytes],
        headers: dict[str, str],
        media_type: str,
        leave: Callable[[], None],
    ) -> None:
        super().__init__(body, headers=headers, media_type=media_type)
        self._leave = leave

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._leave()


def _since(request: HTTPConnection) -> int | None:
    """Return the stamp after which somebody goes on, ns; None: he did not say."""
    text = request.query_params.get('since')
    return None if text is None else since_ns(text)


def _takes_gzip(accepted: str) -> bool:
    codings = [coding.replace(' ', '').lower().split(';') for coding in accepted.split(',')]
    return any(name == 'gzip' and 'q=0' not in rest for name, *rest in codings)


def _answer(text: str, status: int) -> Response:
    headers = {'connection': 'close'}
    if status == 503:
        headers['retry-after'] = _AGAIN_S
    return PlainTextResponse(text, status, headers)
