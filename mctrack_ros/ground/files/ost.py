"""Cameras in the old text format of ROS's `camera_calibration` (`ost.txt`, `.ini`)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.several_cameras import ANY, Choice

_SECTION = re.compile(r'\[(.+)\]')
_NUMBERS = re.compile(r'[-+\d].*')


def is_ost(content: bytes) -> bool:
    """Tell whether a file is in this format: no other begins its sections so."""
    return re.search(rb'(?m)^\s*\[image\]\s*$', content) is not None


def read_ost(path: str | Path, choice: Choice = ANY) -> dict[str, Any]:
    """
    Return what a file says of one camera: lists of numbers, by their headings.

    Parameters
    ----------
    path : str or Path
        The file.
    choice : Choice
        Which camera of several.

    Raises
    ------
    CalibrationError
        If the file has another form, or the camera could be one of several.

    """
    sections = _sections(path)
    image, externals = sections.pop('image', {}), sections.pop('externals', {})
    if any(any(numbers) for numbers in externals.values()):
        raise CalibrationError(
            f'{path}: [externals] are of a camera to another, not to the ground: take them out'
        )
    if not sections:
        raise CalibrationError(f'{path}: no section of a camera')
    name = choice.of(dict.fromkeys(sections, ''), path)
    sides = {key: value[0] if len(value) == 1 else value for key, value in image.items()}
    return sides | sections[name]


def _sections(path: str | Path) -> dict[str, dict[str, list[float]]]:
    """Return the numbers below each heading of each section."""
    sections: dict[str, dict[str, list[float]]] = {}
    below: dict[str, list[float]] = {}
    numbers: list[float] | None = None
    for number, line in enumerate(Path(path).read_text(encoding='utf-8').splitlines(), 1):
        text = line.strip()
        if not text or text[0] in '#;':
            continue
        section = _SECTION.fullmatch(text)
        if section is not None:
            below = sections.setdefault(section[1], {})
            numbers = None
        elif not sections:
            raise CalibrationError(f'{path}:{number}: {text!r} before any section')
        elif not _NUMBERS.fullmatch(text):
            numbers = below.setdefault(text, [])
        elif numbers is None:
            raise CalibrationError(f'{path}:{number}: numbers without a heading')
        else:
            numbers.extend(_read(text, f'{path}:{number}'))
    return sections


def _read(text: str, where: str) -> list[float]:
    try:
        return [float(each) for each in text.split()]
    except ValueError as error:
        raise CalibrationError(f'{where}: {text!r}, expected numbers') from error
