"""The live map beside another command: it runs from when somebody opens its page."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from types import TracebackType
from typing import Self

HOST = '127.0.0.1'
PORT = 8080
_NICE = 10
"""What the map gives way to: whatever it shows."""
_PATIENCE_S = 5.0
_PAGE = b"""<!doctype html><title>mctrack</title>
<body style="background:#14181d;color:#dfe5ea;font:16px system-ui;padding:40px">The map starts ...
<script>setInterval(() => fetch('/').then(() => location.reload()).catch(() => {}), 700)</script>
"""


class LazyMap:
    """
    Serve the live map while a command runs; a context manager.

    Until its page is asked for, nothing runs but a socket that waits. The map then runs as a
    process that gives way to all others.

    Parameters
    ----------
    arguments : sequence of str
        Of `mctrack map`, without its address.
    log : Path
        What the map says, replaced.
    domain : int, optional
        ROS domain; by default that of the environment.

    Attributes
    ----------
    address : str
        Of the page.
    process : Popen or None
        The map, once it was asked for.
    has_failed : bool
        Whether it ended before the command did; the log says why.

    """

    def __init__(self, arguments: Sequence[str], log: Path, domain: int | None = None) -> None:
        self._arguments, self._log, self._domain = tuple(arguments), log, domain
        self.process: subprocess.Popen[bytes] | None = None
        self.has_failed = False
        self._ended = threading.Event()

    def __enter__(self) -> Self:
        """Wait for somebody."""
        try:
            self._server = _Waiting(PORT)
        except OSError:  # the usual port is taken: any
            self._server = _Waiting(0)
        self._port = int(self._server.server_address[1])
        self.address = f'http://{HOST}:{self._port}/'
        self._thread = threading.Thread(target=self._wait, name='lazy map', daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the map, if it runs."""
        self._ended.set()
        self._thread.join()
        if self.process is not None:
            self.has_failed = self.process.poll() is not None
            self.process.terminate()
            try:
                self.process.wait(_PATIENCE_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()

    def _wait(self) -> None:
        with self._server as server:
            while not (self._ended.is_set() or server.is_asked):
                server.handle_request()
        if not self._ended.is_set():
            self._start()

    def _start(self) -> None:
        command = [sys.executable, '-P', '-m', 'mctrack_ros.cli.main', 'map', *self._arguments]
        command += ['--port', str(self._port), '--no-browser']
        command += [] if self._domain is None else ['--domain', str(self._domain)]
        with self._log.open('wb') as log:
            self.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT
            )
        os.setpriority(os.PRIO_PROCESS, self.process.pid, _NICE)


class _Waiting(HTTPServer):
    """Waits at a port until somebody has asked for the map."""

    timeout = 0.5
    is_asked = False

    def __init__(self, port: int) -> None:
        super().__init__((HOST, port), _Answer)


class _Answer(BaseHTTPRequestHandler):
    """Answers with a page that looks for the map until it is there."""

    def do_GET(self) -> None:
        """Answer."""
        is_page = self.path == '/'
        self.send_response(200 if is_page else 404)
        self.send_header('Content-Type', 'text/html; charset=utf-8')
        self.end_headers()
        if is_page and isinstance(self.server, _Waiting):
            self.wfile.write(_PAGE)
            self.server.is_asked = True

    def log_message(self, format: str, *arguments: object) -> None:
        """Say nothing."""
