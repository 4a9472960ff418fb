"""Tokens and passwords: from the environment or a file, never from a URL or a parameter."""

from __future__ import annotations

import os
from pathlib import Path

from mctrack_ros.config import ConfigError
from mctrack_ros.input_size import check_size

_LARGEST = 4096
TOKEN_VARIABLE = 'MCTRACK_STREAM_TOKEN'  # noqa: S105  its name


def stream_token(file: str) -> str:
    """
    Return the token of the stream: of the environment, or the first line of a file; empty: none.

    Raises
    ------
    ConfigError
        If the file cannot be read.

    """
    return os.environ.get(TOKEN_VARIABLE, '') or (_lines(file)[:1] or [''])[0]


def user_and_password(service: str, file: str) -> tuple[str, str]:
    """
    Return user name and password, empty where there is none.

    Parameters
    ----------
    service : str
        ``MQTT`` or ``VIDEO``: those of the environment, as ``MCTRACK_<service>_USERNAME`` and
        ``MCTRACK_<service>_PASSWORD``, come first.
    file : str
        File that holds them, a line each; empty: none.

    Raises
    ------
    ConfigError
        If the file cannot be read.

    """
    user = os.environ.get(f'MCTRACK_{service}_USERNAME', '')
    if user:
        return user, os.environ.get(f'MCTRACK_{service}_PASSWORD', '')
    lines = [*_lines(file), '', '']
    return lines[0], lines[1]


def _lines(file: str) -> list[str]:
    if not file:
        return []
    check_size(file, _LARGEST, ConfigError)
    try:
        return Path(file).read_text(encoding='utf-8').splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f'{file} cannot be read: {error}') from error
