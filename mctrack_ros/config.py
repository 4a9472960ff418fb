"""
Typed configuration from nested values.

A frozen dataclass beside each algorithm holds its parameters, made with `parameter`; it is the
single source of their names, types, defaults, units, ranges and descriptions. YAML files and ROS
parameters are checked against it. Where a method is chosen, each has a dataclass of its own, and
`OneOf` holds that of the chosen one: no other method's parameters exist then.
"""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

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
    at_run_time : bool
        Whether it may be set while the node is configured.
    is_tag : bool
        Whether it names a method, on which it depends what other parameters there are.

    """

    name: str
    kind: type
    default: Value
    description: str
    minimum: float | None
    maximum: float | None
    choices: tuple[str, ...]
    at_run_time: bool = False
    is_tag: bool = False

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
    at_run_time: bool = False,
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
    at_run_time : bool, optional
        Whether a node takes another value while it runs.

    """
    metadata = {
        'description': description,
        'minimum': minimum,
        'maximum': maximum,
        'choices': choices,
        'at_run_time': at_run_time,
    }
    return dataclasses.field(default=default, metadata=metadata)


def tag(*methods: str) -> Any:
    """Declare the field that says which of some methods a configuration dataclass is of."""
    return parameter(methods[0], 'the method that these parameters are of', choices=methods)


class Method(Protocol):
    """An entry in a registry of methods, whatever else it holds."""

    @property
    def config(self) -> type[Any]:
        """The configuration dataclass."""
        ...


@dataclass(frozen=True, eq=False)
class OneOf(Generic[Config]):
    """
    One of several methods, chosen by a parameter that stands beside the method's own.

    A field made by `field` holds the configuration dataclass of the chosen one, which has the
    tag's field itself, made by `tag`: ``{model: interacting, calm_density: 0.1}`` names a method
    and a parameter that it alone has.

    Attributes
    ----------
    tag : str
        The parameter that names the method.
    default : str
        The method, unless one is named.
    description : str
        What is chosen.
    methods : mapping of str to type or Method
        The configuration dataclass of each, or what holds it. What is added to the mapping later
        can be chosen from then on.

    """

    tag: str
    default: str
    description: str
    methods: Mapping[str, type[Any] | Method]

    def field(self) -> Any:
        """Declare a field of a configuration dataclass that holds the chosen method's."""
        return dataclasses.field(default_factory=self.made, metadata={'one_of': self})

    def made(self, method: str = '') -> Config:
        """Return the configuration of a method, or the default one, as it comes."""
        name = method or self.default
        return self.kind(name)(**{self.tag: name})

    def kind(self, method: str) -> type[Config]:
        """Return a method's configuration dataclass."""
        entry = self.methods[method]
        return entry if isinstance(entry, type) else entry.config

    def parameter(self, prefix: str = '') -> Parameter:
        """Return the parameter that names the method."""
        name, choices = prefix + self.tag, tuple(self.methods)
        return Parameter(
            name, str, self.default, self.description, None, None, choices, is_tag=True
        )


def parameters_of(
    kind: type[Any] | OneOf[Any], prefix: str = '', given: Mapping[str, Any] | None = None
) -> Iterator[Parameter]:
    """
    Yield every parameter of a configuration, nested ones under dotted names.

    Parameters
    ----------
    kind : type or OneOf
        A configuration dataclass, or several of which one is chosen.
    prefix : str
        Dotted name of what contains it.
    given : mapping of str to object, optional
        Values by whole dotted name. Of methods that these do not choose, it is the default.

    Raises
    ------
    ConfigError
        If a method that they choose does not exist.

    """
    given = given or {}
    if isinstance(kind, OneOf):
        yield kind.parameter(prefix)
        own = parameters_of(_chosen(kind, prefix, given), prefix, given)
        yield from (each for each in own if each.name != prefix + kind.tag)
        return
    for name, field in _fields(kind).items():
        if field.is_section:
            yield from parameters_of(field.kind, f'{prefix}{name}.', given)
        else:
            yield field.declared(prefix + name)


def config_from(
    kind: type[Config] | OneOf[Config], values: Mapping[str, Any], prefix: str = ''
) -> Config:
    """
    Build a configuration dataclass from nested values; what is not given keeps its default.

    Parameters
    ----------
    kind : type or OneOf
        A frozen dataclass of `parameter` fields and further such dataclasses, or several of which
        the values choose one.
    values : mapping
        Values by field name, nested.
    prefix : str
        Dotted name of what contains it, for messages.

    Raises
    ------
    ConfigError
        If a key is not known or of a method that is not chosen, a value of the wrong type or out
        of range; says which.

    """
    if not isinstance(values, Mapping):
        raise ConfigError(f'{prefix.rstrip(".") or "the file"} is {values!r}, expected a mapping')
    if isinstance(kind, OneOf):
        values = {kind.tag: kind.default} | dict(values)
    given = {prefix + name: value for name, value in values.items()}
    made = _chosen(kind, prefix, given)
    fields = _fields(made)
    arguments: dict[str, Any] = {}
    for key, value in values.items():
        if key not in fields:
            reason = misplaced(kind, key, prefix, given)
            expected = f', expected one of {sorted(fields)}'
            raise ConfigError(reason or f'unknown key {prefix}{key}{expected}')
        field = fields[key]
        if field.is_section:
            arguments[key] = config_from(field.kind, value, f'{prefix}{key}.')
        else:
            arguments[key] = field.declared(prefix + key).checked(value)
    return made(**arguments)


def misplaced(
    kind: type[Any] | OneOf[Any], name: str, prefix: str, given: Mapping[str, Any]
) -> str:
    """
    Return why a configuration lacks a parameter that another method has; empty: none has it.

    Parameters
    ----------
    kind : type or OneOf
        A configuration dataclass, or several of which one is chosen.
    name : str
        Dotted name of the parameter, or of what contains some, behind the prefix.
    prefix : str
        Dotted name of what contains it.
    given : mapping of str to object
        Values by whole dotted name; they choose the methods.

    """
    key, _, rest = name.partition('.')
    field = _fields(_chosen(kind, prefix, given)).get(key)
    if field is not None and field.is_section and rest:
        reason = misplaced(field.kind, rest, f'{prefix}{key}.', given)
        if reason:
            return reason
    if not isinstance(kind, OneOf):
        return ''
    owners = [each for each in kind.methods if _has(kind.kind(each), name)]
    if not owners:
        return ''
    chosen = given.get(prefix + kind.tag, kind.default)
    return (
        f'{prefix}{name} belongs to {kind.tag} {" or ".join(owners)}, '
        f'but {prefix}{kind.tag} is {chosen}'
    )


def of_chosen(kind: type[Any] | OneOf[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested values without those that belong to methods that they do not choose."""
    fields = _fields(_chosen(kind, '', values))
    kept = {}
    for name, value in values.items():
        if name in fields:
            field = fields[name]
            is_whole = field.is_section and isinstance(value, Mapping)
            kept[name] = of_chosen(field.kind, value) if is_whole else value
        elif not _has(kind, name):
            kept[name] = value
    return kept


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


def _chosen(
    kind: type[Config] | OneOf[Config], prefix: str, given: Mapping[str, Any]
) -> type[Config]:
    """Return the configuration dataclass that values, by whole dotted name, choose."""
    if not isinstance(kind, OneOf):
        return kind
    choice = kind.parameter(prefix)
    return kind.kind(str(choice.checked(given.get(choice.name, choice.default))))


def _has(kind: type[Any] | OneOf[Any], name: str) -> bool:
    """Tell whether there is a parameter, or what contains some, of a dotted name."""
    if isinstance(kind, OneOf):
        return any(_has(kind.kind(method), name) for method in kind.methods)
    key, _, rest = name.partition('.')
    field = _fields(kind).get(key)
    if field is None or not rest:
        return field is not None
    return field.is_section and _has(field.kind, rest)


class _Field(NamedTuple):
    """A field: the type of its value, or what it contains."""

    field: dataclasses.Field[Any]
    kind: Any

    @property
    def is_section(self) -> bool:
        return isinstance(self.kind, OneOf) or dataclasses.is_dataclass(self.kind)

    def declared(self, name: str) -> Parameter:
        plain = typing.get_origin(self.kind) or self.kind
        return Parameter(
            name, plain, typing.cast(Value, self.field.default), **self.field.metadata
        )


def _fields(kind: type[Any]) -> dict[str, _Field]:
    """Return the fields of a configuration dataclass by name."""
    if kind not in _FIELDS:
        types = typing.get_type_hints(kind)
        _FIELDS[kind] = {
            field.name: _Field(field, field.metadata.get('one_of', types[field.name]))
            for field in dataclasses.fields(kind)
        }
    return _FIELDS[kind]


_FIELDS: dict[type[Any], dict[str, _Field]] = {}
"""What was looked up of configuration dataclasses before."""


def _range_text(low: float | None, high: float | None) -> str:
    if low is None:
        return f'at most {high}'
    return f'at least {low}' if high is None else f'{low} to {high}'


def replace_parameters(tracker: object, before: object, after: object) -> None:
    """
    Give a tracker, of fusion or of a camera, other parameters while it goes on.

    Only those may differ that it reads each time: the ones that may be set at run time.

    Parameters
    ----------
    tracker : object
        What has them, or whose parts do.
    before, after : dataclass
        The parameters that it has, and those that it gets.

    """
    _replace(tracker, dict(_sections(before, after)), set())


def _sections(before: object, after: object) -> Iterator[tuple[int, object]]:
    """Yield the dataclasses in a configuration, by identity, and what takes their place."""
    yield id(before), after
    for field in dataclasses.fields(before):  # type: ignore[arg-type]
        value = getattr(before, field.name)
        if dataclasses.is_dataclass(value):
            yield from _sections(value, getattr(after, field.name))


def _replace(value: object, others: Mapping[int, object], seen: set[int]) -> None:
    seen.add(id(value))
    for name, each in attributes_of(value):
        if id(each) in others:
            object.__setattr__(value, name, others[id(each)])
        elif type(each).__module__.startswith('mctrack_ros.') and id(each) not in seen:
            _replace(each, others, seen)


def attributes_of(value: object) -> Iterator[tuple[str, Any]]:
    """Yield name and value of each attribute of an object."""
    slots = [name for kind in type(value).__mro__ for name in getattr(kind, '__slots__', ())]
    for name in dict.fromkeys([*getattr(value, '__dict__', {}), *slots]):
        if hasattr(value, name):
            yield name, getattr(value, name)
