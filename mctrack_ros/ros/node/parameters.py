"""Parameters of a node, declared from its configuration dataclass and checked against it."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node

from mctrack_ros.config import (
    ConfigError,
    Parameter,
    config_from,
    misplaced,
    nested,
    parameters_of,
)

Config = TypeVar('Config')

_OF_RCLPY = ('use_sim_time', 'start_type_description_service')
_LARGEST = 2**63 - 1


def declare(node: Node, kind: type[Any]) -> None:
    """
    Declare every field of a configuration dataclass, with its description and range.

    Of methods of which one is chosen, only the parameters of that one are declared.

    The node must have been made with ``automatically_declare_parameters_from_overrides``, so
    that what the user gave can be seen, whether known or not.

    Raises
    ------
    ConfigError
        If a parameter was given that is not known, of the wrong type or out of range.

    """
    given = {name: value for name, value in _values(node).items() if not _is_of_rclpy(name)}
    known = {parameter.name: parameter for parameter in parameters_of(kind, given=given)}
    for name in given:
        if name not in known:
            raise ConfigError(
                misplaced(kind, name, '', given)
                or f'unknown parameter {name}: {_suggestion(name, list(known))}'
            )
        node.undeclare_parameter(name)
    for parameter in known.values():
        _declare(node, parameter, given.get(parameter.name, parameter.default))


def read(node: Node, kind: type[Config]) -> Config:
    """Return the configuration that a node's parameters hold now."""
    values = _values(node)
    return config_from(kind, nested({name: values[name] for name in _known(node, kind)}))


def refuse_changes(node: Node, kind: type[Any], fixed: Callable[[Parameter], bool]) -> None:
    """
    Let parameters change only while they are not fixed, and only to valid values.

    When another method is named, its parameters are declared, with their defaults, in place of
    those of the one before.
    """

    def judge(changes: list[Any]) -> SetParametersResult:
        known = _known(node, kind)
        for change in changes:
            if change.name not in known:
                continue
            if fixed(known[change.name]):
                reason = (
                    f'{change.name} takes effect on configuration: clean the node up first (ros2 '
                    f'lifecycle set {node.get_fully_qualified_name()} deactivate, then cleanup), '
                    'set it, then configure and activate'
                )
                return SetParametersResult(successful=False, reason=reason)
            try:
                known[change.name].checked(change.value)
            except ConfigError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def follow(changes: list[Any]) -> None:
        known = _known(node, kind)
        if any(change.name in known and known[change.name].is_tag for change in changes):
            _declare_anew(node, known)

    node.add_on_set_parameters_callback(judge)
    node.add_post_set_parameters_callback(follow)


def already_are(node: Node, wanted: Sequence[Any]) -> bool:
    """
    Return whether parameters already have the values that are asked for.

    ``ros2 param load`` hands over what YAML makes of a value's text: a number for the string
    ``'0'``, a string for the number 1e-05, bytes for an empty list. So it is the text that counts.

    """
    return all(
        node.has_parameter(one.name) and str(node.get_parameter(one.name).value) == str(one.value)
        for one in wanted
    )


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Return a parameter's description and range as ROS states them."""
    low, high = parameter.minimum, parameter.maximum
    described = ParameterDescriptor(description=parameter.description)
    if parameter.choices:
        described.additional_constraints = 'one of ' + ', '.join(parameter.choices)
    if low is None and high is None:
        return described
    if parameter.kind is int:
        first = -_LARGEST - 1 if low is None else int(low)
        last = _LARGEST if high is None else int(high)
        described.integer_range = [IntegerRange(from_value=first, to_value=last)]
    elif parameter.kind is float:
        first_real = -sys.float_info.max if low is None else float(low)
        last_real = sys.float_info.max if high is None else float(high)
        described.floating_point_range = [
            FloatingPointRange(from_value=first_real, to_value=last_real)
        ]
    return described


def _declare(node: Node, parameter: Parameter, value: Any) -> None:
    """Declare a parameter with a value, which is checked."""
    checked = _as_ros(parameter.checked(value))
    node.declare_parameter(parameter.name, checked, descriptor(parameter), ignore_override=True)


def _declare_anew(node: Node, known: Mapping[str, Parameter]) -> None:
    """See to it that a node has some parameters and no others, but for those of rclpy."""
    for name in _values(node):
        if name not in known and not _is_of_rclpy(name):
            node.undeclare_parameter(name)
    for name, parameter in known.items():
        if not node.has_parameter(name):
            _declare(node, parameter, parameter.default)


def _known(node: Node, kind: type[Any]) -> dict[str, Parameter]:
    """Return the parameters, by name, that the methods named by a node's parameters have."""
    return {each.name: each for each in parameters_of(kind, given=_values(node))}


def _values(node: Node) -> dict[str, Any]:
    """Return the values of a node's parameters by name."""
    return {name: item.value for name, item in node.get_parameters_by_prefix('').items()}


def _suggestion(name: str, known: list[str]) -> str:
    """Return the names that are most like a wrong one."""
    near = difflib.get_close_matches(name, known, n=3, cutoff=0.7)
    if near:
        return f'was {" or ".join(near)} meant?'
    return 'the files in config/ list all that there are'


def _as_ros(value: Any) -> Any:
    """Return a value as rclpy types it; it takes lists, not tuples, for arrays."""
    return list(value) if isinstance(value, tuple) else value


def _is_of_rclpy(name: str) -> bool:
    return name in _OF_RCLPY or name.startswith('qos_overrides.')
