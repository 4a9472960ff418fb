"""The answer of a node to ``--help``, read from its parameter file."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import takewhile

from mctrack_ros.resources import config_file

_DEEPEST = 2
"""Parameters whose names have more parts than this are only counted."""
_WIDTH = 95
_STEP = '  '


def asked_for_help(arguments: Sequence[str]) -> bool:
    """Tell whether a command line asks for help."""
    return not {'-h', '--help'}.isdisjoint(arguments)


def usage(node: str) -> str:
    """
    Return what a node does and its parameters, those far down only counted.

    It is read from the node's parameter file, so that nothing of the node need be loaded.

    Parameters
    ----------
    node : str
        Executable, after which its parameter file is called.

    """
    file = config_file(f'{node}.yaml')
    summary, *rest = file.read_text(encoding='utf-8').splitlines()
    lines = [f'usage: {node} --ros-args [-p NAME:=VALUE ...] [--params-file FILE]', '']
    lines += [summary.removeprefix('# '), '', 'parameters, each with its default:']
    header = list(takewhile(lambda line: line.startswith('# '), rest))
    methods = [line.removeprefix('# ') for line in header[1:]]
    deeper: Counter[str] = Counter()
    for name, default, description in _parameters(rest):
        parts = name.split('.')
        if len(parts) > _DEEPEST:
            deeper['.'.join(parts[:_DEEPEST])] += 1
            continue
        lines.append(f'  {name}: {default}')
        lines += textwrap.wrap(
            description, _WIDTH, initial_indent=6 * ' ', subsequent_indent=6 * ' '
        )
    lines += [f'  {name}.*: {count} more' for name, count in deeper.items()]
    lines += ['', *methods] if methods else []
    return '\n'.join([*lines, '', f'A parameter file with all of them: {file}'])


def _parameters(lines: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield dotted name, default and description of what a shipped parameter file lists."""
    above: list[str] = []
    comment: list[str] = []
    for line in lines:
        text = line.strip()
        if text.startswith('#'):
            comment.append(text.removeprefix('# '))
            continue
        key, _, value = text.partition(':')
        depth = (len(line) - len(line.lstrip())) // len(_STEP) - 2
        above[max(depth, 0) :] = [key]
        if value and depth >= 0:
            yield '.'.join(above), value.strip(), ' '.join(comment)
        comment.clear()
