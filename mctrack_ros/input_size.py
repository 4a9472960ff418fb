"""Files from elsewhere are refused when they are larger than any that is meant."""

from __future__ import annotations

from pathlib import Path

SETTINGS = 16 << 20
"""Of a file of settings or calibrations, bytes."""
IMAGE = 256 << 20
"""Of the file of an image, bytes."""
TABLE = 2 << 30
"""Of a file of tracks or detections, which is read as a whole, bytes."""

SITE = 1 << 20
"""Of what `/site` says, characters."""


def check_size(path: str | Path, most: int, error: type[ValueError]) -> None:
    """
    Refuse a file of more bytes than are expected; one that is not there is left to its reader.

    Parameters
    ----------
    path : str or Path
        The file.
    most : int
        Bytes that it may hold.
    error : type
        What to raise, with the file and its size.

    """
    try:
        size = Path(path).stat().st_size
    except OSError:
        return
    if size > most:
        raise error(f'{path} holds {size} bytes, expected at most {most}')
