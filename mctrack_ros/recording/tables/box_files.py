"""Detections of somebody's own detector as text: MOT text, or a table with a header."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.recording.tables.columns import (
    ABSOLUTE_NS,
    TIMES,
    Spellings,
    Table,
    TableError,
    has_header,
    read_lines,
    read_table,
)
from mctrack_ros.recording.tables.sightings import Floats, Ints, Sightings, check_count, numbered
from mctrack_ros.recording.video.videos import START_NS

COLUMNS: Spellings = {
    **TIMES,
    'left': ('bb_left', 'bbox_left', 'box_left', 'x1', 'xmin', 'x_min', 'left_px'),
    'top': ('bb_top', 'bbox_top', 'box_top', 'y1', 'ymin', 'y_min', 'top_px'),
    'right': ('bb_right', 'bbox_right', 'box_right', 'x2', 'xmax', 'x_max', 'right_px'),
    'bottom': ('bb_bottom', 'bbox_bottom', 'box_bottom', 'y2', 'ymax', 'y_max', 'bottom_px'),
    'width': ('w', 'bb_width', 'bbox_width', 'box_width', 'width_px'),
    'height': ('h', 'bb_height', 'bbox_height', 'box_height', 'height_px'),
    'center_x': ('cx', 'x_center', 'centre_x', 'x_centre', 'xc'),
    'center_y': ('cy', 'y_center', 'centre_y', 'y_centre', 'yc'),
    'x': ('x_m', 'ground_x', 'world_x'),
    'y': ('y_m', 'ground_y', 'world_y'),
    'sigma': ('sigma_m', 'std', 'std_m'),
    'score': ('conf', 'confidence', 'probability', 'prob'),
    'class': ('class_name', 'class_id', 'label', 'category', 'cls', 'type'),
    'id': ('track_id', 'local_id', 'object_id', 'tracker_id', 'person_id', 'target_id'),
}
"""Columns of a table of detections, each with other names for the same."""
_MOT = ('frame', 'id', 'left', 'top', 'width', 'height', 'score')
_MOT_CLASSES = {
    '1': 'pedestrian', '2': 'person on vehicle', '3': 'car', '4': 'bicycle', '5': 'motorbike',
    '6': 'non motorized vehicle', '7': 'static person', '8': 'distractor', '9': 'occluder',
    '10': 'occluder on the ground', '11': 'occluder full', '12': 'reflection',
}  # fmt: skip
"""Of MOT16 and later, where lines have a class: 8 or 9 fields."""
_SCORES = (0.0, 1.0)
_SHARES = 2.0
"""Boxes of which no number is larger are shares of an image, not pixels."""


@dataclass(frozen=True, slots=True)
class TextClock:
    """
    What the text does not say of its times and scores.

    Attributes
    ----------
    rate_hz : float
        Images a second; 0: not known.
    first_frame : int
        Number of the first image.
    later_s : float
        How long after the first camera this one began, s; of times that do not count from 1970.
    score_range : (float, float)
        The scores that stand for 0 and for 1.

    """

    rate_hz: float = 0.0
    first_frame: int = 1
    later_s: float = 0.0
    score_range: tuple[float, float] = _SCORES


def read_boxes(path: str | Path, clock: TextClock) -> Sightings:
    """
    Read what a detector saw, from MOT text or a table with a header.

    Parameters
    ----------
    path : str or Path
        The file; `COLUMNS` are those of a table.
    clock : TextClock
        What it does not say.

    Raises
    ------
    TableError
        If it cannot be used; names file, line and reason.

    """
    is_table = has_header(read_lines(path))
    table = read_table(path, COLUMNS) if is_table else _mot_table(path, clock)
    if not len(table):
        raise TableError(f'{path} holds no rows')
    stamps, images, interval_ns = _times(table, clock)
    box, position = _boxes(table), _positions(table)
    is_seen = np.isfinite(box[:, 0])
    is_seen |= np.isfinite(position[:, 0])
    score = _scores(table, clock.score_range, is_seen)
    rows = np.argsort(stamps, kind='stable')
    rows = rows[is_seen[rows]]
    return Sightings(
        stamp_ns=images,
        image=np.searchsorted(images, stamps[rows]),
        box=box[rows],
        position=position[rows],
        sigma=_sigma(table)[rows],
        score=score[rows],
        label=np.array(table.texts('class'), np.str_)[rows],
        local_id=numbered([table.texts('id')[row] for row in rows]),
        interval_ns=interval_ns,
        unused=table.unused,
    )


def _mot_table(path: str | Path, clock: TextClock) -> Table:
    """Return the columns of MOT text, split by commas or blanks; -1 is for what is unknown."""
    cells: dict[str, list[str]] = {name: [] for name in (*_MOT, 'x', 'y', 'class')}
    numbers = []
    for number, line in enumerate(read_lines(path), 1):
        if not line.strip():
            continue
        fields = re.split(r'[,\s]+', line.strip().rstrip(','))
        if len(fields) < len(_MOT):
            raise TableError(
                f'{path}, line {number}: {len(fields)} fields, expected at least {len(_MOT)}: '
                'frame,id,left,top,width,height,score of MOT text, or a header with names'
            )
        further = fields[len(_MOT) :]
        row = dict(zip(_MOT, fields)) | {'x': '', 'y': '', 'class': _mot_class(further)}
        if all(_is_none(text) for text in fields[2:6]):
            row |= dict.fromkeys(('left', 'top', 'width', 'height'), '')
            if len(further) >= 3 and not all(_is_none(text) for text in further[:3]):
                row |= {'x': further[0], 'y': further[1]}
        if _is_none(row['id']):
            row['id'] = ''
        if _is_none(row['score']) and clock.score_range == _SCORES:
            row['score'] = '1'
        for name, text in row.items():
            cells[name].append(text)
        numbers.append(number)
    return Table(path, np.array(numbers, np.int64), cells, ())


def _is_none(text: str) -> bool:
    return re.fullmatch(r'-1(\.0*)?', text) is not None


def _mot_class(further: list[str]) -> str:
    """Return the class in a line of 8 or 9 fields."""
    if len(further) not in (1, 2) or _is_none(further[0]):
        return ''
    return _MOT_CLASSES.get(further[0], further[0])


def _times(table: Table, clock: TextClock) -> tuple[Ints, Ints, float]:
    """Return the stamp of each row, those of all images known of, and the interval, ns."""
    stamps = table.stamps_ns()
    if stamps is None:
        return _frame_times(table, clock)
    back = np.flatnonzero(np.diff(stamps) < 0)
    if back.size:
        raise table.error(
            int(back[0]) + 1, 'the time goes back: sort the rows by time, a recording a file'
        )
    is_absolute = stamps >= ABSOLUTE_NS
    if is_absolute.any() and not is_absolute.all():
        raise table.error(
            int(np.flatnonzero(is_absolute)[0]),
            'the time counts from 1970, and in lines before it does not',
        )
    if is_absolute.any() and clock.later_s:
        raise TableError(f'{table.path}: its times count from 1970: --later cannot move them')
    if not is_absolute.any():
        stamps += START_NS + round(clock.later_s * 1e9)
    images = np.unique(stamps)
    interval = 1e9 / clock.rate_hz if clock.rate_hz else 0.0
    if not interval and len(images) > 1:
        interval = _usual_gap(np.diff(images))
    return stamps, images, interval


def _usual_gap(gaps: Ints) -> float:
    """Return the time between images: of the gaps those without missing images, a quarter."""
    short = np.quantile(gaps, 0.25, method='lower')
    return float(np.median(gaps[gaps < 1.5 * short]))


def _frame_times(table: Table, clock: TextClock) -> tuple[Ints, Ints, float]:
    """Return the same of frames, each the middle of its period: as `mctrack import-videos`."""
    if 'frame' not in table.cells:
        raise TableError(f'{table.path} has neither a column time nor frame')
    if not clock.rate_hz:
        raise TableError(f'{table.path} counts frames: say by --rate how many there are a second')
    frame = table.whole_numbers('frame', clock.first_frame) - clock.first_frame
    check_count(int(frame.max()) + 1, str(table.path))
    index = np.arange(int(frame.max()) + 1)
    seconds = clock.later_s + (index + 0.5) / clock.rate_hz
    images = START_NS + np.rint(seconds * 1e9).astype(np.int64)
    return images[frame], images, 1e9 / clock.rate_hz


def _boxes(table: Table) -> Floats:
    """Return (n, 4) boxes; NaN where a row has none."""
    across = _side(table, 'left', 'right', 'center_x', 'width')
    down = _side(table, 'top', 'bottom', 'center_y', 'height')
    if (across is None) != (down is None):
        given = 'horizontally' if down is None else 'vertically'
        raise TableError(f'{table.path} has the columns of a box only {given}')
    if across is None or down is None:
        return np.full((len(table), 4), np.nan)
    box = np.column_stack([across[0], down[0], across[1], down[1]])
    known = np.isfinite(box)
    for row in np.flatnonzero(known.any(axis=1) & ~known.all(axis=1)):
        raise table.error(row, 'a part of the box is empty')
    for row in np.flatnonzero((box[:, 2:] <= 0).any(axis=1)):
        raise table.error(
            row, f'the box is {box[row, 2]:g} x {box[row, 3]:g} px, expected sizes above 0'
        )
    if known.any() and np.nanmax(np.abs(box)) <= _SHARES:
        raise TableError(f'{table.path}: the boxes are shares of the image, expected pixels')
    return box


def _side(
    table: Table, low: str, high: str, centre: str, size: str
) -> tuple[Floats, Floats] | None:
    """Return beginning and size of boxes along one axis; None: there is no column."""
    given = {
        name: table.numbers(name) for name in (low, high, centre, size) if name in table.cells
    }
    if low in given and size in given:
        return given[low], given[size]
    if low in given and high in given:
        return given[low], given[high] - given[low]
    if centre in given and size in given:
        return given[centre] - given[size] / 2, given[size]
    if not given:
        return None
    if set(given) == {size} and {'x', 'y'} & table.cells.keys():
        raise TableError(
            f'{table.path}: are x and y metres on the ground or pixels of the box? Name them '
            'ground_x and ground_y, or left and top'
        )
    raise TableError(
        f'{table.path}: {" and ".join(given)} alone is no box: expected {low} and {size}, '
        f'{low} and {high}, or {centre} and {size}'
    )


def _positions(table: Table) -> Floats:
    """Return (n, 2) places; NaN where a row has none."""
    if ('x' in table.cells) != ('y' in table.cells):
        raise TableError(f'{table.path}: only one of the columns x and y is there')
    place = np.column_stack([table.numbers('x'), table.numbers('y')])
    for row in np.flatnonzero(np.isfinite(place[:, 0]) != np.isfinite(place[:, 1])):
        raise table.error(row, 'only one of x and y is filled in')
    if not {'x', 'left', 'center_x'} & table.cells.keys():
        raise TableError(
            f'{table.path} has the columns of neither a box (left, top, width, height) nor a '
            'position (x, y)'
        )
    return place


def _sigma(table: Table) -> Floats:
    sigma = table.numbers('sigma')
    for row in np.flatnonzero(sigma <= 0):
        raise table.error(row, f'sigma is {sigma[row]:g} m, expected more than 0')
    return sigma


def _scores(table: Table, limits: tuple[float, float], is_seen: NDArray[np.bool_]) -> Floats:
    if 'score' not in table.cells:
        raise TableError(f'{table.path} has no column score')
    score, (low, high) = table.numbers('score'), limits
    for row in np.flatnonzero(is_seen & np.isnan(score)):
        raise table.error(row, 'the score is empty')
    for row in np.flatnonzero(is_seen & ~((score >= low) & (score <= high))):
        least, most = np.nanmin(score), np.nanmax(score)
        asked = (0, 100) if least >= 0 and 1 < most <= 100 else (min(least, 0), max(most, 1))
        raise table.error(
            row,
            f'the score is {score[row]:g}, expected {low:g} to {high:g}; those of the file are '
            f'{least:g} to {most:g}: --score-range={asked[0]:g},{asked[1]:g}?',
        )
    return (score - low) / (high - low)
