"""Text and times in XML and JSON."""

from __future__ import annotations

from datetime import UTC, datetime
from xml.sax.saxutils import quoteattr

_LATEST_NS = 253402300799 * 10**9
"""The end of the year 9999, the last that a date can name, ns."""


def attribute(text: str) -> str:
    """Return text as the value of an XML attribute, quoted; signs that XML lacks are left out."""
    return quoteattr(''.join(sign for sign in text if sign.isprintable()))


def utc(stamp_ns: int) -> str:
    """Return a stamp as a date and time of day, UTC, down to the microsecond."""
    seconds, rest_ns = divmod(min(stamp_ns, _LATEST_NS), 10**9)
    day = datetime.fromtimestamp(seconds, UTC).strftime('%Y-%m-%dT%H:%M:%S')
    return f'{day}.{rest_ns // 1000:06d}Z'


def since_ns(text: str) -> int:
    """
    Return the stamp after which somebody goes on, ns.

    Parameters
    ----------
    text : str
        A stamp in ns, or a date and time as `utc` writes them, its whole microsecond included.

    Raises
    ------
    ValueError
        If it is neither.

    """
    if text.isascii() and text.isdigit() and len(text) < 20:
        return int(text)
    try:
        when = datetime.fromisoformat(text)
    except ValueError as error:
        raise ValueError(
            'since is no time: expected ns, or for example 2026-01-31T12:00:00Z'
        ) from error
    if when.tzinfo is None:
        when = when.replace(tzinfo=UTC)
    passed = when - datetime.fromtimestamp(0, UTC)
    return (passed.days * 86400 + passed.seconds) * 10**9 + passed.microseconds * 1000 + 999
