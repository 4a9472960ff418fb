"""Times as people read them."""

from __future__ import annotations


def clock(seconds: float, decimals: int = 1) -> str:
    """Return a time as ``m:ss.s``, or ``h:mm:ss.s`` from an hour on."""
    factor = 10**decimals
    units = round(abs(seconds) * factor)
    whole, rest = divmod(units, factor)
    minutes, second = divmod(whole, 60)
    hours, minute = divmod(minutes, 60)
    text = f'{hours}:{minute:02d}:{second:02d}' if hours else f'{minute}:{second:02d}'
    fraction = f'.{rest:0{decimals}d}' if decimals else ''
    return f'{"-" if seconds < 0 and units else ""}{text}{fraction}'
