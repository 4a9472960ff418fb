"""What lies under a map of a site: a floor plan, or a pitch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mctrack_ros.config import ConfigError

PITCH = 'pitch'
KINDS = {'.png': 'image/png', '.jpg': 'image/jpeg', '.jpeg': 'image/jpeg'}
"""Media type of an image by the ending of its file."""


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """
    An image of the floor, its upper edge in the direction of y.

    Attributes
    ----------
    path : Path
        PNG or JPEG.
    corners : (float, float, float, float)
        Left, low, right and high edge in the coordinates of the site's files, m.

    """

    path: Path
    corners: tuple[float, float, float, float]


def floor_plan(text: str, directory: Path) -> FloorPlan | None:
    """
    Read ``file x0,y0,x1,y1``, the file relative to a directory; None: empty, or ``pitch``.

    Raises
    ------
    ConfigError
        If it is neither; says why.

    """
    if text in ('', PITCH):
        return None
    file, _, numbers = text.rpartition(' ')
    path = directory / file.strip()
    if not file or path.suffix.lower() not in KINDS:
        raise ConfigError(
            f'plan is {text!r}, expected pitch, or a file (PNG or JPEG) and the corners that it '
            'covers, for example floor.png 0,0,40,25'
        )
    try:
        x0, y0, x1, y1 = (float(number) for number in numbers.split(','))
    except ValueError as error:
        raise ConfigError(f'plan: {numbers!r} are no corners x0,y0,x1,y1 in metres') from error
    corners = (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))
    if not (corners[0] < corners[2] and corners[1] < corners[3]):
        raise ConfigError(f'plan: the corners {numbers} span no area')
    if not path.is_file():
        raise ConfigError(f'plan: there is no file {path}')
    return FloorPlan(path.resolve(), corners)
