"""
Typed configuration from nested values.

A frozen dataclass beside each algorithm holds its parameters, made with `parameter`; it is the
single source of their names, types, defaults, units, ranges and descriptions. YAML files and ROS
parameters are checked against it.
"""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

Config = TypeVar('Config')
Value = bool | int | float | str | tuple[str, ...]


class ConfigError(ValueError):
    """A configuration value that is unknown, of the wrong type or out of range."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """
    One parameter with its dotted name, as ROS declares it.

    Attributes
    ----------
    name : str
        Dotted name.
    kind : type
        ``bool``, ``int``, ``float``, ``str`` or ``tuple`` (of strings).
    default : bool, int, float, str or tuple of str
        Its default.
    description : str
        What it does, with its unit.
    minimum, maximum : float or None
        Its range, ends included.
    choices : tuple of str
        What a string may be; empty: anything.

    """

    name: str
    kind: type
    default: Value
    description: str
    minimum: float | None
    maximum: float | None
    choices: tuple[str, ...]

    def explained(self) -> str:
        """Return the description with what the value may be."""
        text, low, high = self.description, self.minimum, self.maximum
        if self.choices:
            text += f' ({" or ".join(self.choices)})'
        if low is not None and high is not None:
            text += f' ({low:g} to {high:g})'
        elif low is not None:
            text += f' (at least {low:g})'
        elif high is not None:
            text += f' (at most {high:g})'
        return text

    def checked(self, value: Any) -> Value:
        """Return the value in the parameter's type, or raise `ConfigError`."""
        if self.kind is tuple:
            return self._checked_strings(value)
        fits = isinstance(value, self.kind) and not (
            isinstance(value, bool) and self.kind is not bool
        )
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool):
            fits, value = True, float(value)
        if not fits:
            raise ConfigError(f'{self.name} is {value!r}, expected {_ARTICLED[self.kind]}')
        if self.kind is float and not math.isfinite(value):
            raise ConfigError(f'{self.name} is {value!r}, expected a finite number')
        low, high = self.minimum, self.maximum
        if (low is not None and value < low) or (high is not None and value > high):
            raise ConfigError(f'{self.name} is {value!r}, expected {_range_text(low, high)}')
        if self.choices and value not in self.choices:
            raise ConfigError(f'{self.name} is {value!r}, expected one of {list(self.choices)}')
        return typing.cast(Value, value)

    def _checked_strings(self, value: Any) -> tuple[str, ...]:
        listed = isinstance(value, (list, tuple)) and all(isinstance(item, str) for item in value)
        if not listed:
            raise ConfigError(f'{self.name} is {value!r}, expected a list of strings')
        return tuple(value)


_ARTICLED = {bool: 'true or false', int: 'a whole number', float: 'a number', str: 'a string'}


def parameter(
    default: Value,
    description: str,
    *,
    minimum: float | None = None,
    maximum: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """
    Declare a field of a configuration dataclass.

    Parameters
    ----------
    default : bool, int, float, str or tuple of str
        The default.
    description : str
        What it does, its unit in brackets at the end.
    minimum, maximum : float, optional
        The range, ends included.
    choices : tuple of str, optional
        What a string may be.

    """
    metadata = {
        'description': description,
        'minimum': minimum,
        'maximum': maximum,
        'choices': choices,
    }
    return dataclasses.field(default=default, metadata=metadata)


def parameters_of(kind: type[Any], prefix: str = '') -> Iterator[Parameter]:
    """Yield every parameter of a configuration dataclass, nested ones under dotted names."""
    types = typing.get_type_hints(kind)
    for field in dataclasses.fields(kind):
        name, field_type = prefix + field.name, types[field.name]
        if dataclasses.is_dataclass(field_type):
            yield from parameters_of(typing.cast(type[Any], field_type), name + '.')
        else:
            yield _declared(name, field_type, field)


def config_from(kind: type[Config], values: Mapping[str, Any], prefix: str = '') -> Config:
    """
    Build a configuration dataclass from nested values; what is not given keeps its default.

    Parameters
    ----------
    kind : type
        A frozen dataclass of `parameter` fields and further such dataclasses.
    values : mapping
        Values by field name, nested.
    prefix : str
        Dotted name of what contains it, for messages.

    Raises
    ------
    ConfigError
        If a key is not known, a value of the wrong type or out of range; says which.

    """
    if not isinstance(values, Mapping):
        raise ConfigError(f'{prefix.rstrip(".") or "the file"} is {values!r}, expected a mapping')
    types = typing.get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(typing.cast(Any, kind))}
    for key in values:
        if key not in fields:
            raise ConfigError(f'unknown key {prefix}{key}, expected one of {sorted(fields)}')
    arguments: dict[str, Any] = {}
    for name, value in values.items():
        field_type = types[name]
        if dataclasses.is_dataclass(field_type):
            arguments[name] = config_from(
                typing.cast(type[Any], field_type), value, f'{prefix}{name}.'
            )
        else:
            arguments[name] = _declared(prefix + name, field_type, fields[name]).checked(value)
    return kind(**arguments)


def nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Turn dotted names into nested dictionaries."""
    tree: dict[str, Any] = {}
    for name, value in flat.items():
        *parents, leaf = name.split('.')
        branch = tree
        for parent in parents:
            branch = branch.setdefault(parent, {})
        branch[leaf] = value
    return tree


def values_of(config: Any) -> dict[str, Any]:
    """Return a configuration's values, nested, as YAML writes them."""
    return dataclasses.asdict(config)


def _declared(name: str, kind: type, field: dataclasses.Field[Any]) -> Parameter:
    plain = typing.get_origin(kind) or kind
    return Parameter(name, plain, typing.cast(Value, field.default), **field.metadata)


def _range_text(low: float | None, high: float | None) -> str:
    if low is None:
        return f'at most {high}'
    return f'at least {low}' if high is None else f'{low} to {high}'
