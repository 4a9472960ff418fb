"""What a node says of itself when it is asked by ``--help``."""

from __future__ import annotations

import textwrap
from collections import Counter
from typing import Any

import yaml

from mctrack_ros.config import parameters_of
from mctrack_ros.resources import config_file

_DEEPEST = 2
"""Parameters whose names have more parts than this are only counted."""
_WIDTH = 95


def usage(program: str, documentation: str, configuration: type[Any]) -> str:
    """
    Return what a node does and its parameters, those far down only counted.

    Parameters
    ----------
    program : str
        Of the node, after which its parameter file is called, too.
    documentation : str
        Docstring of the node; its first line is shown.
    configuration : type
        Dataclass of the parameters.

    """
    summary = documentation.strip().splitlines()[0]
    lines = [f'usage: {program} --ros-args [-p NAME:=VALUE ...] [--params-file FILE]', '']
    lines += [*textwrap.wrap(summary, _WIDTH), '', 'parameters, each with its default:']
    deeper: Counter[str] = Counter()
    for parameter in parameters_of(configuration):
        parts = parameter.name.split('.')
        if len(parts) > _DEEPEST:
            deeper['.'.join(parts[:_DEEPEST])] += 1
            continue
        lines.append(f'  {parameter.name}: {yaml_text(parameter.default)}')
        lines += textwrap.wrap(
            parameter.explained(), _WIDTH, initial_indent=6 * ' ', subsequent_indent=6 * ' '
        )
    lines += [f'  {name}.*: {count} more' for name, count in deeper.items()]
    file = config_file(f'{program}.yaml')
    return '\n'.join([*lines, '', f'A parameter file with all of them: {file}'])


def yaml_text(value: Any) -> str:
    """Return a value as YAML writes it in one line."""
    plain = list(value) if isinstance(value, tuple) else value
    return yaml.safe_dump(plain, default_flow_style=True, width=1000).removesuffix('...\n').strip()
