"""A PostgreSQL server of Debian's packages, in a folder of its own, without a network port."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

_PROGRAMS = Path('/usr/lib/postgresql')
_EXTENSIONS = Path('/usr/share/postgresql')
_PATIENCE_S = 60.0
_SETTINGS = ('shared_buffers=64MB', 'jit=off', 'listen_addresses=')


def missing() -> str:
    """Return what lacks for a server; empty: nothing."""
    if _programs() is None:
        return 'apt install postgresql'
    if not list(_EXTENSIONS.glob('*/extension/postgis.control')):
        return "apt install 'postgresql-*-postgis-3'"
    return ''


def _programs() -> Path | None:
    """Return the folder of the newest server's programs; None: there is none."""
    return max((path.parent for path in _PROGRAMS.glob('*/bin/initdb')), default=None)


class Server:
    """
    A server, by its folder; databases in it have PostGIS.

    Parameters
    ----------
    folder : Path
        Its own, empty.
    settings : sequence of str
        Of the server, ``name=value``.

    """

    def __init__(self, folder: Path, settings: Sequence[str]) -> None:
        programs = _programs()
        if programs is None:
            raise RuntimeError(f'no PostgreSQL: {missing()}')
        self._folder, self._count, self._programs = folder, 0, programs
        self._settings = [f'-c{each}' for each in (*_SETTINGS, *settings)]
        self._user: dict[str, Any] = {'user': 'postgres'} if os.getuid() == 0 else {}
        self._process: Any = None
        make: list[str | Path] = [
            programs / 'initdb',
            '-D',
            folder / 'data',
            '-U',
            'postgres',
            '-A',
            'trust',
            '-N',
        ]
        more = ['-E', 'UTF8', '--locale=C']
        out = subprocess.DEVNULL
        subprocess.run([*make, *more], cwd=folder, check=True, stdout=out, **self._user)

    def start(self) -> None:
        """Start it, and wait until it answers; raises `OSError` if it does not in a minute."""
        import psycopg

        command: list[str | Path] = [
            self._programs / 'postgres',
            '-D',
            self._folder / 'data',
            *self._settings,
        ]
        with (self._folder / 'log').open('ab') as log:
            self._process = subprocess.Popen(
                [*command, '-k', self._folder],
                cwd=self._folder,
                stdout=log,
                stderr=log,
                **self._user,
            )
        until_s = time.monotonic() + _PATIENCE_S
        while True:
            try:
                psycopg.connect(self.url('postgres')).close()
            except psycopg.OperationalError as error:
                if self._process.poll() is not None or time.monotonic() > until_s:
                    said = (self._folder / 'log').read_text()
                    raise OSError(f'PostgreSQL does not start: {said}') from error
                time.sleep(0.05)
            else:
                return

    def stop(self) -> None:
        """Stop it, in good order but without waiting for clients."""
        if self._process is not None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait(_PATIENCE_S)

    def kill(self) -> None:
        """Kill all its processes at once."""
        first = self._process.pid
        children = Path(f'/proc/{first}/task/{first}/children').read_text().split()
        processes = [first, *map(int, children)]
        for process in processes:
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        self._process.wait()
        while any(_is_alive(process) for process in processes):
            time.sleep(0.01)

    def url(self, name: str) -> str:
        """Return the URL of a database."""
        return f'postgresql://postgres@/{name}?host={quote(str(self._folder), safe="")}'

    def execute(self, statement: str, name: str = 'postgres') -> None:
        """Run a statement outside of a transaction."""
        import psycopg

        with psycopg.connect(self.url(name), autocommit=True) as connection:
            connection.execute(statement.encode())

    def new_database(self) -> str:
        """Return the URL of a new database."""
        self._count += 1
        name = f'tracks{self._count}'
        self.execute(f'CREATE DATABASE {name} TEMPLATE with_postgis')
        return self.url(name)


def _is_alive(process: int) -> bool:
    """Tell whether a process still has memory; one that waits to be collected has none."""
    try:
        return ') Z ' not in Path(f'/proc/{process}/stat').read_text()
    except FileNotFoundError:
        return False


@contextmanager
def postgres_server(*settings: str) -> Iterator[Server]:
    """
    Yield a server, which ends with the block.

    It refuses to run as root: then it runs as the user ``postgres``, whom the package makes.
    """
    folder = Path(tempfile.mkdtemp(prefix='mctrack-pg-'))
    if os.getuid() == 0:
        os.chown(folder, pwd.getpwnam('postgres').pw_uid, -1)
    try:
        server = Server(folder, settings)
        server.start()
        try:
            server.execute('CREATE DATABASE with_postgis')
            server.execute('CREATE EXTENSION postgis', 'with_postgis')
            yield server
        finally:
            server.stop()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
