"""Serve a page until it is interrupted."""

from __future__ import annotations

import socket
from collections.abc import Callable

from nicegui import app, ui

from mctrack_ros.web.guard import Guard, check_address


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
        Given the page's address.

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
    path = f'/?token={token}' if token else '/'
    shown = f'[{host}]' if ':' in host else host
    app.on_startup(lambda: tell(f'http://{shown}:{port}{path} (Ctrl-C ends)'))
    ui.run(
        page,
        host=host,
        port=port,
        title=title,
        show=path if show else False,
        reload=False,
        show_welcome_message=False,
    )


def _check_free(host: str, port: int) -> None:
    family = socket.AF_INET6 if ':' in host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise OSError(f'{host}:{port} cannot be used: {error.strerror}') from error
