"""A PostgreSQL server of Debian's packages, in a folder of its own, without a network port."""

import os
import pwd
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote

import psycopg

BINARIES = Path('/usr/lib/postgresql')
EXTENSION = Path('/usr/share/postgresql')
SETTINGS = ('fsync=off', 'synchronous_commit=on', 'shared_buffers=64MB', 'jit=off')


def missing():
    """Return what lacks for a server; empty: nothing."""
    if binaries() is None:
        return 'apt install postgresql'
    if not list(EXTENSION.glob('*/extension/postgis.control')):
        return 'apt install postgresql-*-postgis-3'
    try:
        pwd.getpwnam('postgres')
    except KeyError:
        return 'a user postgres' if os.getuid() == 0 else ''
    return ''


def binaries():
    """Return the folder of the newest server's programs; None: there is none."""
    return max((path.parent for path in BINARIES.glob('*/bin/initdb')), default=None)


class Server:
    """A running server; databases in it have PostGIS."""

    def __init__(self, folder):
        self.folder, self.count = folder, 0

    def url(self, name):
        return f'postgresql://postgres@/{name}?host={quote(str(self.folder), safe="")}'

    def execute(self, statement, name='postgres'):
        with psycopg.connect(self.url(name), autocommit=True) as connection:
            connection.execute(statement)

    def new_database(self):
        """Return the URL of a new database."""
        self.count += 1
        name = f'test{self.count}'
        self.execute(f'CREATE DATABASE {name} TEMPLATE with_postgis')
        return self.url(name)


@contextmanager
def postgres_server(*settings):
    """Yield a server, which ends with the block; it refuses to run as root."""
    folder = Path(tempfile.mkdtemp(prefix='mctrack-pg-'))
    user = {'user': 'postgres'} if os.getuid() == 0 else {}
    if user:
        os.chown(folder, pwd.getpwnam('postgres').pw_uid, -1)
    data, control = folder / 'data', binaries() / 'pg_ctl'
    run = {'check': True, 'stdout': subprocess.DEVNULL, 'cwd': folder, **user}
    options = ' '.join(f'-c {each}' for each in (*SETTINGS, *settings))
    options += f" -c listen_addresses='' -k {folder}"
    try:
        make = [binaries() / 'initdb', '-D', data, '-U', 'postgres', '-A', 'trust', '-N']
        subprocess.run([*make, '-E', 'UTF8', '--locale=C'], **run)
        log = ['-l', folder / 'log', '-w', '-s']
        subprocess.run([control, '-D', data, *log, '-o', options, 'start'], **run)
        try:
            server = Server(folder)
            server.execute('CREATE DATABASE with_postgis')
            server.execute('CREATE EXTENSION postgis', 'with_postgis')
            yield server
        finally:
            subprocess.run([control, '-D', data, '-w', '-s', '-m', 'immediate', 'stop'], **run)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
