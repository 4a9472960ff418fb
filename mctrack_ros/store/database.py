"""A trajectory database by its URL: SQLite or PostgreSQL with PostGIS."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from mctrack_ros.recording.closing import Closing
from mctrack_ros.store.errors import StoreError

_MIGRATIONS = str(Path(__file__).parent / 'migrations')
_MAPPED = 1 << 30
"""Bytes of SQLite's file that are read without a call each."""
_BUSY_S = 30
"""How long SQLite waits for another who writes."""
_SNAPSHOT = {
    'sqlite': 'BEGIN',
    'postgresql': 'SET TRANSACTION ISOLATION LEVEL REPEATABLE READ',
}
_ALONE = {
    'sqlite': 'BEGIN IMMEDIATE',
    'postgresql': 'LOCK TABLE runs, event_messages IN SHARE ROW EXCLUSIVE MODE',
}
"""What lets others wait who begin to write."""
_RELEASE = {
    'sqlite': ('PRAGMA wal_checkpoint(TRUNCATE)',),
    'postgresql': ('VACUUM',),
}
"""SQLite has overwritten it in the file, but not in the log; PostgreSQL frees it for others."""
_REACHED_S = 10
"""How long a server may take to answer a call."""


class Database(Closing):
    """
    A trajectory database.

    Parameters
    ----------
    place : str or Path
        A file of SQLite, or a URL: ``sqlite:///tracks.db``, ``postgresql://user@host/name``. A
        password is told by PostgreSQL's own means: ``~/.pgpass``, ``PGPASSWORD``.
    create : bool
        Whether it is made, or brought to the version of this package, where it is not.

    Raises
    ------
    StoreError
        If it cannot be opened, is not of the version of this package, or its URL holds a password.

    """

    def __init__(self, place: str | Path, *, create: bool = False) -> None:
        self.url = url_of(place)
        self.name = self.url.render_as_string(hide_password=True)
        path = self.url.database if self.url.get_backend_name() == 'sqlite' else None
        if path is not None and not create and not Path(path).is_file():
            raise StoreError(f'there is no database {path}: mctrack store BAG {path} makes one')
        self.engine = self._engine()
        try:
            with self.connected() as connection:
                self._check_version(connection, create)
        except BaseException:
            self.engine.dispose()
            raise

    def close(self) -> None:
        """Close its connections."""
        self.engine.dispose()

    @contextmanager
    def connected(self) -> Iterator[Connection]:
        """Yield a connection; what is written with it is there as a whole, or not at all."""
        try:
            with self.engine.begin() as connection:
                yield connection
        except SQLAlchemyError as error:
            raise StoreError(f'{self.name}: {_one_line(error)}') from error

    @contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """Yield a connection as `connected` does, that sees the database at one instant."""
        with self.connected() as connection:
            connection.exec_driver_sql(_SNAPSHOT[connection.dialect.name])
            yield connection

    @contextmanager
    def alone(self) -> Iterator[Connection]:
        """Yield a connection as `connected` does, while nobody else writes tracks or events."""
        with self.connected() as connection:
            connection.exec_driver_sql(_ALONE[connection.dialect.name])
            yield connection

    def release(self) -> None:
        """Let nothing of what was deleted stay in files, as far as that is up to this package."""
        statements = _RELEASE[self.url.get_backend_name()]
        with self.engine.connect().execution_options(isolation_level='AUTOCOMMIT') as connection:
            for statement in statements:
                connection.exec_driver_sql(statement)

    def _engine(self) -> Engine:
        if self.url.get_backend_name() == 'sqlite':
            engine = create_engine(self.url, connect_args={'timeout': _BUSY_S})
            event.listen(engine, 'connect', _set_up_sqlite)
            return engine
        try:
            import psycopg  # noqa: F401
        except ImportError as error:
            raise StoreError(f"{self.name} needs pip install 'psycopg[binary]'") from error
        options = {} if 'connect_timeout' in self.url.query else {'connect_timeout': _REACHED_S}
        return create_engine(self.url, connect_args=options)

    def _check_version(self, connection: Connection, create: bool) -> None:
        config = Config()
        config.set_main_option('script_location', _MIGRATIONS.replace('%', '%%'))
        config.set_main_option('path_separator', 'os')
        config.attributes['connection'] = connection
        wanted = ScriptDirectory.from_config(config).get_current_head()
        found = MigrationContext.configure(connection).get_current_revision()
        if found == wanted:
            return
        if not create:
            state = f'is of version {found}' if found else 'is no trajectory database'
            raise StoreError(f'{self.name} {state}: mctrack store makes and upgrades it')
        try:
            command.upgrade(config, 'head')
        except SQLAlchemyError:
            raise
        except Exception as error:  # alembic's own: a version that this package does not know
            raise StoreError(f'{self.name} is of version {found}: {_one_line(error)}') from error


def url_of(place: str | Path) -> URL:
    """
    Return the URL of a place: it is that already, or a file of SQLite.

    Raises
    ------
    StoreError
        If it cannot be read, is of another kind of database, or holds a password.

    """
    if '://' not in str(place):
        return URL.create('sqlite', database=str(place))
    try:
        url = make_url(str(place))
        backend = url.get_backend_name()
    except (ArgumentError, ValueError) as error:
        raise StoreError('the URL of the database cannot be read') from error
    if url.password is not None or 'password' in url.query:
        raise StoreError(
            'the URL of the database holds a password, which others would see: '
            'tell it by ~/.pgpass or PGPASSWORD'
        )
    if backend == 'postgresql':
        return url.set(drivername='postgresql+psycopg')
    if backend != 'sqlite' or not url.database:
        raise StoreError(f'a database of {backend} is not known: sqlite or postgresql')
    return url


def _set_up_sqlite(connection: Any, _: object) -> None:
    """
    Readers do not wait for the writer; what is committed outlives the process.

    What is deleted is overwritten.
    """
    cursor = connection.cursor()
    cursor.execute('PRAGMA journal_mode=WAL')
    cursor.execute('PRAGMA synchronous=NORMAL')
    cursor.execute('PRAGMA foreign_keys=ON')
    cursor.execute('PRAGMA secure_delete=ON')
    cursor.execute('PRAGMA cache_size=-4096')  # of a store's process; files are mapped beside it
    cursor.execute(f'PRAGMA mmap_size={_MAPPED}')
    cursor.close()


def _one_line(error: BaseException) -> str:
    reason = getattr(error, 'orig', None) or error
    return ' '.join(str(reason).split())
