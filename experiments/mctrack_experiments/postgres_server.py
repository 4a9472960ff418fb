"""A PostgreSQL server of Debian's packages, in a folder of its own, without a network port."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

_PROGRAMS = Path('/usr/lib/postgresql')
_EXTENSIONS = Path('/usr/share/postgresql')
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
    """A running server, by its folder; databases in it have PostGIS."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._count = folder, 0

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


@contextmanager
def postgres_server(*settings: str) -> Iterator[Server]:
    """
    Yield a server, which ends with the block.

    It refuses to run as root: then it runs as the user ``postgres``, whom the package makes.
    """
    programs = _programs()
    if programs is None:
        raise RuntimeError(f'no PostgreSQL: {missing()}')
    folder = Path(tempfile.mkdtemp(prefix='mctrack-pg-'))
    run: dict[str, Any] = {'check': True, 'stdout': subprocess.DEVNULL, 'cwd': folder}
    if os.getuid() == 0:
        os.chown(folder, pwd.getpwnam('postgres').pw_uid, -1)
        run['user'] = 'postgres'
    data, control = folder / 'data', programs / 'pg_ctl'
    options = ' '.join(f"-c '{each}'" for each in (*_SETTINGS, *settings)) + f' -k {folder}'
    try:
        make: list[str | Path] = [
            programs / 'initdb',
            '-D',
            data,
            '-U',
            'postgres',
            '-A',
            'trust',
            '-N',
        ]
        subprocess.run([*make, '-E', 'UTF8', '--locale=C'], **run)
        begin: list[str | Path] = [control, '-D', data, '-l', folder / 'log', '-w', '-s']
        subprocess.run([*begin, '-o', options, 'start'], **run)
        try:
            server = Server(folder)
            server.execute('CREATE DATABASE with_postgis')
            server.execute('CREATE EXTENSION postgis', 'with_postgis')
            yield server
        finally:
            subprocess.run([control, '-D', data, '-w', '-s', '-m', 'fast', 'stop'], **run)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
