"""An origin as files and parameters state it: ``x,y`` in metres."""

from __future__ import annotations

import math

from mctrack_ros.config import ConfigError

Origin = tuple[float, float]


def origin_from(text: str) -> Origin:
    """
    Read an origin, ``x,y`` in metres.

    Raises
    ------
    ConfigError
        If it is none.

    """
    try:
        x, y = (float(number) for number in text.split(','))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ConfigError(
            f'origin is {text!r}, expected x,y in metres, for example 389000,5820000'
        )
    return x, y


def origin_text(origin: Origin) -> str:
    """Return an origin as `origin_from` reads it."""
    return ','.join(f'{value:.15g}' for value in origin)
