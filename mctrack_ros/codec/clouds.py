"""Rows of the interfaces as `sensor_msgs/PointCloud2` and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from reprlib import repr as shortened
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec.messages import CodecError, MessageClasses, header, stamp_ns_of
from mctrack_ros.interfaces import Column, Rows

MOST_ROWS = 1 << 20
"""Of a cloud: a camera's likelihoods are some ten thousand."""
AnyRows = TypeVar('AnyRows', bound=Rows)

_POINT_FIELD_TYPES = {'i1': 1, 'u1': 2, 'i2': 3, 'u2': 4, 'i4': 5, 'u4': 6, 'f4': 7, 'f8': 8}
_NUMPY_TYPES = {code: name for name, code in _POINT_FIELD_TYPES.items()}


@dataclass(frozen=True, slots=True)
class _Layout:
    """How one row type lies in a cloud: packed type and, per column, its triangle."""

    dtype: np.dtype[np.void]
    triangles: dict[str, tuple[NDArray[np.intp], NDArray[np.intp]]]


def cloud_from_rows(rows: Rows, classes: MessageClasses, frame_id: str) -> Any:
    """
    Encode rows as a ``sensor_msgs/PointCloud2``.

    Little-endian, 4-byte fields first and bytes last, ``point_step`` a multiple of 4,
    covariances as row-major upper triangles; an empty array still carries its fields.

    Parameters
    ----------
    rows : Rows
        Any row type of the interfaces.
    classes : MessageClasses
        Of rclpy or of rosbags.
    frame_id : str
        Frame of the positions.

    Returns
    -------
    object
        The message. Its field descriptions are shared with other messages: copy before changing.

    """
    kind: Any = type(rows)
    layout = _layout(kind)
    packed = np.zeros(len(rows), layout.dtype)
    position = rows.position
    for axis, name in enumerate('xyz'):
        packed[name] = position[:, axis]
    for name in rows.COLUMNS:
        if name == 'position':
            continue
        values = getattr(rows, name)
        if name in layout.triangles:
            upper, right = layout.triangles[name]
            values = values[:, upper, right]
        packed[name] = values
    step = layout.dtype.itemsize
    return classes.cloud(
        header=header(classes, rows.stamp_ns, frame_id),
        height=1,
        width=len(rows),
        fields=list(_point_fields(kind, classes)),
        is_bigendian=False,
        point_step=step,
        row_step=step * len(rows),
        data=classes.octets(packed.view(np.uint8).reshape(-1)),
        is_dense=bool(np.isfinite(position).all()),
    )


def rows_from_cloud(message: Any, kind: type[AnyRows]) -> AnyRows:
    """
    Decode a ``sensor_msgs/PointCloud2``.

    Parameters
    ----------
    message : object
        A message of rclpy or rosbags.
    kind : type
        The row type expected.

    Returns
    -------
    Rows
        Of that type; further fields of the message are passed over, optional ones may be absent.

    Raises
    ------
    CodecError
        If fields are missing or of another type, sizes disagree, or a value is not finite
        that must be.

    """
    hashable: Any = kind
    layout = _layout(hashable)
    optional = [name for name, column in kind.COLUMNS.items() if column.absent is not None]
    packed = _packed_array(message, layout.dtype, kind.__name__, optional)
    columns: dict[str, NDArray[Any]] = {}
    for name, column in kind.COLUMNS.items():
        if name == 'position':
            values = np.stack([packed[axis] for axis in 'xyz'], axis=1)
        elif name not in (packed.dtype.names or ()):
            values = np.full((len(packed), *column.shape), column.absent, column.dtype)
        elif name in layout.triangles:
            upper, right = layout.triangles[name]
            values = np.empty((len(packed), *column.shape), column.dtype)
            values[:, upper, right] = packed[name]
            values[:, right, upper] = packed[name]
        else:
            values = np.ascontiguousarray(packed[name])
        _check_finite(name, column, values, bool(message.is_dense))
        columns[name] = values
    return kind(stamp_ns=stamp_ns_of(message), **columns)


def further_fields(message: Any, kind: type[Rows]) -> list[str]:
    """Return the fields of a cloud that rows of a type lack: decoding leaves them out."""
    hashable: Any = kind
    known = _layout(hashable).dtype.names or ()
    return [str(field.name) for field in message.fields if str(field.name) not in known]


def fields_of_cloud(message: Any) -> dict[str, NDArray[Any]]:
    """
    Read every field of a cloud by the message's own description.

    Returns
    -------
    dict of str to array
        By field name, (n,) or (n, count).

    Raises
    ------
    CodecError
        If sizes disagree or are too large, a field's type is not known, or it occurs twice.

    """
    formats = []
    for field in message.fields:
        if int(field.datatype) not in _NUMPY_TYPES:
            raise CodecError(
                f'field {shortened(field.name)} has the unknown datatype {field.datatype}'
            )
        element, count = '<' + _NUMPY_TYPES[int(field.datatype)], int(field.count)
        formats.append((str(field.name), element, (count,) if count > 1 else ()))
    try:
        expected = np.dtype(formats)
    except ValueError as error:
        raise CodecError(f'a cloud has fields that cannot be: {error}') from error
    packed = _packed_array(message, expected, 'rows')
    return {name: np.ascontiguousarray(packed[name]) for name, _, _ in formats}


def _packed_array(
    message: Any, expected: np.dtype[np.void], name: str, optional: Sequence[str] = ()
) -> NDArray[Any]:
    """Return a structured view of a cloud's data, checked; optional fields may be absent."""
    if message.is_bigendian:
        raise CodecError(f'a big-endian cloud of {name} cannot be read')
    given = {str(field.name): field for field in message.fields}
    if len(given) < len(message.fields):
        raise CodecError(f'a cloud of {name} has two fields of one name')
    offsets, absent = [], set(optional) - given.keys()
    names = [field_name for field_name in expected.names or () if field_name not in absent]
    for field_name in names:
        element, shape = expected[field_name].subdtype or (expected[field_name], ())
        count = shape[0] if shape else 1
        field = given.get(field_name)
        if field is None:
            raise CodecError(f'a cloud of {name} lacks the field {field_name!r}')
        kind = _NUMPY_TYPES.get(int(field.datatype), 'unknown')
        if kind != element.str[1:] or int(field.count) != count:
            raise CodecError(
                f'field {field_name!r} of a cloud of {name} is {field.count} x {kind}, '
                f'expected {count} x {element.str[1:]}'
            )
        if field.offset + expected[field_name].itemsize > message.point_step:
            raise CodecError(f'field {field_name!r} of a cloud of {name} exceeds its point_step')
        offsets.append(int(field.offset))
    formats = [expected[field_name] for field_name in names]
    _check_apart(names, formats, offsets, name)
    rows = int(message.height) * int(message.width)
    if rows > MOST_ROWS:
        raise CodecError(f'a cloud of {rows} {name}, expected at most {MOST_ROWS}')
    data = np.frombuffer(message.data, np.uint8)
    if data.size != rows * message.point_step:
        raise CodecError(
            f'a cloud of {rows} {name} holds {data.size} bytes, '
            f'expected {rows * message.point_step}'
        )
    if message.height > 1 and message.row_step != message.width * message.point_step:
        raise CodecError(
            f'a cloud of {name} has the row_step {message.row_step}, '
            f'expected {message.width * message.point_step}'
        )
    if not rows:
        return np.zeros(0, list(zip(names, formats)))
    step = int(message.point_step)
    return data.view(
        np.dtype({'names': names, 'formats': formats, 'offsets': offsets, 'itemsize': step})
    )


def _check_apart(
    names: Sequence[str], formats: Sequence[np.dtype[Any]], offsets: Sequence[int], name: str
) -> None:
    """Refuse fields that share bytes: at most one of them can be right."""
    end, before = 0, ''
    for offset, size, field_name in sorted(
        (offset, form.itemsize, field_name)
        for offset, form, field_name in zip(offsets, formats, names)
    ):
        if offset < end:
            raise CodecError(f'fields {before!r} and {field_name!r} of a cloud of {name} overlap')
        end, before = offset + size, field_name


def _check_finite(name: str, column: Column, values: NDArray[Any], dense: bool) -> None:
    """Refuse NaN and infinity but for the columns where NaN stands for unknown."""
    if column.dtype[0] != 'f':
        return
    if np.isnan(column.fill) and not (name == 'position' and dense):
        bad = np.isinf(values)
    else:
        bad = ~np.isfinite(values)
    if bad.any():
        row = int(np.nonzero(bad.reshape(len(values), -1).any(axis=1))[0][0])
        raise CodecError(f'{name} of row {row} is not finite: {shortened(values[row].tolist())}')


@cache
def _layout(kind: Any) -> _Layout:
    """Return how a row type is packed: x, y, z, then the columns by falling element size."""
    columns = {name: column for name, column in kind.COLUMNS.items() if name != 'position'}
    formats: list[tuple[str, str, tuple[int, ...]]] = [(axis, '<f4', ()) for axis in 'xyz']
    triangles = {}
    for name, column in sorted(
        columns.items(), key=lambda item: -np.dtype(item[1].dtype).itemsize
    ):
        shape = column.shape
        if len(shape) == 2:
            triangles[name] = np.triu_indices(shape[0])
            shape = (len(triangles[name][0]),)
        formats.append((name, '<' + column.dtype, shape))
    used = np.dtype(formats).itemsize
    offsets = np.cumsum([0] + [np.dtype((f[1], f[2])).itemsize for f in formats])[:-1]
    dtype = np.dtype(
        {
            'names': [f[0] for f in formats],
            'formats': [np.dtype((f[1], f[2])) for f in formats],
            'offsets': [int(offset) for offset in offsets],
            'itemsize': -(-used // 4) * 4,
        }
    )
    return _Layout(dtype, triangles)


@cache
def _point_fields(kind: Any, classes: MessageClasses) -> tuple[Any, ...]:
    """Return a row type's ``PointField`` messages; nobody changes them, so all clouds share."""
    dtype = _layout(kind).dtype
    fields = []
    for name in dtype.names or ():
        element, shape = dtype[name].subdtype or (dtype[name], ())
        fields.append(
            classes.field(
                name=name,
                offset=int(dtype.fields[name][1]) if dtype.fields else 0,
                datatype=_POINT_FIELD_TYPES[element.str[1:]],
                count=int(shape[0]) if shape else 1,
            )
        )
    return tuple(fields)
