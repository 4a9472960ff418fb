"""Clouds with something wrong about them, by seed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mctrack_experiments.bench.fusion.hostile_input import SPOILERS
from mctrack_ros.codec import MessageClasses, cloud_from_rows
from mctrack_ros.interfaces import (
    CameraDetections,
    Detections,
    Events,
    Feedback,
    Rows,
    Ticks,
    Tracks,
)

KINDS: tuple[type[Rows], ...] = (Detections, Events, Feedback, Ticks, Tracks)
CONTENTS = ('bad_covariances', 'infinite_positions', 'far_positions', 'wild_ids')
"""What `hostile_input` does to the rows before they are encoded."""

SIZES = (0, 1, 2, 3, 255, 256, 65535, 2**16, 2**20, 2**31 - 1, 2**31, 2**32 - 1)
"""Of the 32 bits of a field, those at which something may break."""
NUMBERS = np.array([np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e-45, -0.0, 1e30], '<f4')
NAMES = ('', 'x', 'Y', 'zz', 'position', 'covariance ', 'ü\n', 'a' * 5000, '%s{0}')

Change = Callable[[Any, MessageClasses, np.random.Generator], None]


def random_rows(kind: type[Rows], rng: np.random.Generator) -> Rows:
    """Return up to five rows of a type, of any values that it may have."""
    count = int(rng.integers(0, 6))
    columns: dict[str, Any] = {}
    for name, column in kind.COLUMNS.items():
        shape = (count, *column.shape)
        if column.dtype[0] == 'f':
            values = rng.uniform(-50.0, 50.0, shape)
            columns[name] = values + values.swapaxes(1, 2) if len(column.shape) == 2 else values
        else:
            columns[name] = rng.integers(0, 200, shape)
    return kind.build(int(rng.integers(0, 2**31)) * 1_000_000_000, **columns)


def malformed_cloud(
    classes: MessageClasses, rng: np.random.Generator, rows: Rows | None = None
) -> tuple[Any, type[Rows]]:
    """
    Return a cloud with one to three changes, and the row type that it was.

    Parameters
    ----------
    classes : MessageClasses
        Of rclpy or of rosbags.
    rng : numpy.random.Generator
        Chooses what is changed.
    rows : Rows, optional
        What it held before; unless given, random rows of any type.

    """
    if rows is None:
        rows = random_rows(KINDS[rng.integers(len(KINDS))], rng)
    if isinstance(rows, Detections) and len(rows) and rng.random() < 0.1:
        spoil = SPOILERS[CONTENTS[rng.integers(len(CONTENTS))]]
        rows = spoil([CameraDetections('cam1', rows)], 0, rng)[0].rows
    message = cloud_from_rows(rows, classes, 'map')
    message.fields = [_copied(each, classes) for each in message.fields]
    names = list(CHANGES)
    for index in rng.choice(len(names), int(rng.integers(1, 4)), replace=False):
        CHANGES[names[index]](message, classes, rng)
    return message, type(rows)


def _copied(field: Any, classes: MessageClasses) -> Any:
    return classes.field(
        name=field.name, offset=field.offset, datatype=field.datatype, count=field.count
    )


def _stamp(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.header.stamp = classes.time(
        sec=int(rng.choice([-(2**31), -1, 0, 2**31 - 1])),
        nanosec=int(rng.choice([0, 999_999_999, 1_000_000_000, 2**32 - 1])),
    )


def _frame(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.header.frame_id = str(rng.choice(NAMES))


def _one_field(message: Any, rng: np.random.Generator) -> Any:
    """Return a field to change; one that nobody asks for, if there is none."""
    if not message.fields:
        return _Nothing()
    return message.fields[rng.integers(len(message.fields))]


class _Nothing:
    """Takes any attribute."""

    name = ''
    offset = datatype = count = 0


def _name(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    _one_field(message, rng).name = str(rng.choice(NAMES))


def _offset(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    near = max(int(message.point_step) + int(rng.integers(-5, 5)), 0)
    _one_field(message, rng).offset = int(rng.choice([near, rng.choice(SIZES)]))


def _datatype(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    _one_field(message, rng).datatype = int(rng.choice([*range(10), 127, 255]))


def _count(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    _one_field(message, rng).count = int(rng.choice(SIZES))


def _without(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    if message.fields:
        del message.fields[rng.integers(len(message.fields))]


def _again(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.fields.append(_copied(_one_field(message, rng), classes))


def _many_fields(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    for index in range(500):
        message.fields.append(
            classes.field(name=f'f{index}', offset=int(rng.choice(SIZES)), datatype=7, count=1)
        )


def _no_fields(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.fields = []


def _size(name: str) -> Change:
    def change(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
        near = max(getattr(message, name) + int(rng.integers(-2, 3)), 0)
        setattr(message, name, int(rng.choice([near, rng.choice(SIZES)])))

    return change


def _turned(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.height, message.width = message.width, message.height


def _order(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.is_bigendian = not message.is_bigendian


def _dense(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.is_dense = not message.is_dense


def octets_of(message: Any) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Return a copy of a message's bytes."""
    return np.frombuffer(message.data, np.uint8).copy()


def _cut(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    data = octets_of(message)
    message.data = classes.octets(data[: rng.integers(0, data.size + 1)])


def _longer(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    more = rng.integers(0, 256, rng.integers(1, 300), np.uint8)
    message.data = classes.octets(np.concatenate([octets_of(message), more]))


def _flipped(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    data = octets_of(message)
    if data.size:
        data[rng.integers(0, data.size, 8)] ^= np.uint8(1) << rng.integers(0, 8, 8, np.uint8)
        message.data = classes.octets(data)


def _noise(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.data = classes.octets(rng.integers(0, 256, len(message.data), np.uint8))


def _numbers(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    data = octets_of(message)
    whole = data[: data.size // 4 * 4].view('<f4')
    if whole.size:
        whole[rng.integers(0, whole.size, 3)] = rng.choice(NUMBERS, 3)
        message.data = classes.octets(data)


CHANGES: Mapping[str, Change] = {
    'stamp': _stamp,
    'frame': _frame,
    'name': _name,
    'offset': _offset,
    'datatype': _datatype,
    'count': _count,
    'without': _without,
    'again': _again,
    'many_fields': _many_fields,
    'no_fields': _no_fields,
    'width': _size('width'),
    'height': _size('height'),
    'point_step': _size('point_step'),
    'row_step': _size('row_step'),
    'turned': _turned,
    'order': _order,
    'dense': _dense,
    'cut': _cut,
    'longer': _longer,
    'flipped': _flipped,
    'noise': _noise,
    'numbers': _numbers,
}
