"""Serve a page until it is interrupted."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable

from nicegui import app, ui

from mctrack_ros.streams.serve.access import check_address
from mctrack_ros.web.serve.guard import Guard

_ASK_S = 0.05


def serve(
    page: Callable[[], None],
    title: str,
    host: str = '127.0.0.1',
    port: int = 8080,
    token: str = '',
    show: bool = True,
    tell: Callable[[str], None] = print,
) -> None:
    """
    Serve a page until Ctrl-C.

    Parameters
    ----------
    page : callable
        Builds the page.
    title : str
        Of the browser's window.
    host, port : str, int
        Where it is bound.
    token : str
        What a request must bring; needed unless the host is this machine's loopback.
    show : bool
        Whether a browser is opened.
    tell : callable
        Given the page's address, without the token, as soon as it answers.

    Raises
    ------
    ValueError
        If other machines reach the host and there is no token.
    OSError
        If the port is taken.

    """
    check_address(host, token)
    _check_free(host, port)
    app.add_middleware(Guard, host=host, token=token)
    asks = 'asks for the token; ' if token else ''
    shown = f'[{host}]' if ':' in host else host

    async def tell_where() -> None:
        await _answering(host, port)
        tell(f'http://{shown}:{port}/ ({asks}Ctrl-C ends)')

    app.on_startup(tell_where)
    ui.run(
        page,
        host=host,
        port=port,
        title=title,
        show=show,
        reload=False,
        show_welcome_message=False,
    )


async def _answering(host: str, port: int) -> None:
    """Wait until somebody listens: the server binds after its application has started."""
    while True:
        try:
            _, writer = await asyncio.open_connection(host, port)
        except OSError:
            await asyncio.sleep(_ASK_S)
        else:
            writer.close()
            return


def _check_free(host: str, port: int) -> None:
    family = socket.AF_INET6 if ':' in host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise OSError(f'{host}:{port} cannot be used: {error.strerror}') from error
