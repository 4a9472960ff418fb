"""Where the package's own files lie: configurations, launch files."""

from __future__ import annotations

import sys
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def share_directory() -> Path:
    """
    Return the folder that holds ``config`` and ``launch``.

    In a checkout that is its root; installed with pip or colcon it is
    ``<prefix>/share/mctrack_ros``, the prefix being above the package.

    Raises
    ------
    FileNotFoundError
        If there is neither.

    """
    checkout = _PACKAGE.parent
    if (checkout / 'package.xml').is_file():
        return checkout
    for prefix in (*_PACKAGE.parents, Path(sys.prefix)):
        shared = prefix / 'share' / 'mctrack_ros'
        if (shared / 'package.xml').is_file():
            return shared
    raise FileNotFoundError(
        f'mctrack_ros was installed without its share folder (looked above {_PACKAGE}): '
        'install it with pip or colcon'
    )


def config_file(name: str) -> Path:
    """Return the path of a shipped configuration, for example ``pitch5.yaml``."""
    return share_directory() / 'config' / name
