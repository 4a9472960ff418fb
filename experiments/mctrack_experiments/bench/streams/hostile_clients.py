"""
Two hundred slow or hostile readers of one server of this machine, in a process of their own.

``python -m mctrack_experiments.bench.streams.hostile_clients PORT SECONDS`` reads a line ``on`` or
``off`` from its standard input for each change; it ends after so many seconds, or with its input.
"""

from __future__ import annotations

import asyncio
import os
import random
import sys
from collections.abc import Awaitable, Callable
from contextlib import suppress

HOST = '127.0.0.1'
"""They trouble nobody but this machine."""
_PAUSE_S = 0.2
"""Between two connections of one client."""
_HELD_S = 30.0
_REQUEST = b'GET /%s HTTP/1.1\r\nHost: localhost\r\n'
_NAMES = (b'tracks.xml', b'tracks.json', b'onvif.xml', b'tracks.xml?since=0')
_SOCKET = (
    b'Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
    b'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n'
)

Client = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


def _ask(writer: asyncio.StreamWriter, more: bytes = b'') -> None:
    writer.write(_REQUEST % random.choice(_NAMES) + more + b'\r\n')


async def never_reads(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Ask, and leave all of the answer in the kernel."""
    writer.transport.pause_reading()  # type: ignore[attr-defined]
    _ask(writer, random.choice((b'', _SOCKET)))
    await asyncio.sleep(_HELD_S)


async def reads_a_byte_a_second(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    """Ask, and read slowly."""
    _ask(writer, b'Accept-Encoding: gzip\r\n')
    for _ in range(round(_HELD_S)):
        if not await reader.read(1):
            return
        await asyncio.sleep(1.0)


async def sends_garbage(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Send what no server understands."""
    writer.write(random.randbytes(2000))
    await reader.read(1000)


async def sends_large_headers(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Send headers without an end."""
    writer.write(_REQUEST % _NAMES[0])
    for number in range(100):
        writer.write(b'X-%d: %s\r\n' % (number, b'x' * 1000))
        await writer.drain()
        if writer.is_closing():
            return
    await reader.read(1000)


async def asks_half(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Ask a byte a second, and never to the end."""
    for byte in _REQUEST[: round(_HELD_S)]:
        writer.write(bytes([byte]))
        await writer.drain()
        if reader.at_eof() or writer.is_closing():
            return
        await asyncio.sleep(1.0)


async def comes_again(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Ask, read a little and break off."""
    _ask(writer, b'Accept-Encoding: gzip\r\n')
    await reader.read(100)
    writer.transport.abort()


KINDS: tuple[tuple[Client, int], ...] = (
    (never_reads, 40),
    (reads_a_byte_a_second, 40),
    (sends_garbage, 30),
    (sends_large_headers, 30),
    (asks_half, 30),
    (comes_again, 30),
)
"""What they do, and how many do it."""


async def _connect_again_and_again(port: int, client: Client) -> None:
    await asyncio.sleep(random.random() * _PAUSE_S)
    while True:
        with suppress(OSError):
            reader, writer = await asyncio.open_connection(HOST, port, limit=1024)
            try:
                await client(reader, writer)
            finally:
                writer.transport.abort()
        await asyncio.sleep(_PAUSE_S)


async def _obey(port: int) -> None:
    """Let the clients run while the last line said ``on``."""
    lines: asyncio.StreamReader = asyncio.StreamReader()
    loop = asyncio.get_running_loop()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(lines), sys.stdin)
    running: list[asyncio.Task[None]] = []
    while line := await lines.readline():
        for task in running:
            task.cancel()
        await asyncio.gather(*running, return_exceptions=True)
        running = []
        if line.strip() == b'on':
            running = [
                asyncio.create_task(_connect_again_and_again(port, client))
                for client, count in KINDS
                for _ in range(count)
            ]


async def _main(port: int, seconds: float) -> None:
    with suppress(TimeoutError):
        await asyncio.wait_for(_obey(port), seconds)


if __name__ == '__main__':
    os.nice(19)  # others' machines compute for them
    asyncio.run(_main(int(sys.argv[1]), float(sys.argv[2])))
