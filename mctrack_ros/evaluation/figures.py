"""Measured figures with the protocol that made them: for people a table, for machines JSON."""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any


class FiguresError(ValueError):
    """A file that does not hold figures; names the file and the reason."""


@dataclass(frozen=True, slots=True)
class Figures:
    """
    What an experiment gave.

    Attributes
    ----------
    name : str
        Of the experiment, for example ``demo``.
    command : str
        The command line that makes the figures again.
    protocol : mapping
        What they hold for: gate, frames, area, seeds ...; the machine is added.
    figures : mapping of str to float
        Values by dotted name; NaN where a value does not exist.

    """

    name: str
    command: str
    protocol: Mapping[str, Any]
    figures: Mapping[str, float]

    def __post_init__(self) -> None:
        """Add the machine to the protocol and keep plain numbers."""
        object.__setattr__(self, 'protocol', {'machine': machine()} | dict(self.protocol))
        plain = {name: _plain(value) for name, value in self.figures.items()}
        object.__setattr__(self, 'figures', plain)

    @classmethod
    def read(cls, path: str | Path) -> Figures:
        """
        Read a file that `write` made.

        Raises
        ------
        FiguresError
            If it is not there, not JSON or of another shape.

        """
        try:
            content = json.loads(Path(path).read_text())
            figures = {
                str(name): float('nan') if value is None else _plain(value)
                for name, value in content['figures'].items()
            }
            return cls(content['name'], content['command'], content['protocol'], figures)
        except (OSError, KeyError, TypeError, AttributeError, ValueError) as error:
            raise FiguresError(f'{path} holds no figures: {error!r}') from error

    def write(self, path: str | Path) -> None:
        """Write the design's JSON shape; NaN becomes null. Parents of the path are made."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        figures = {
            name: value if math.isfinite(value) else None for name, value in self.figures.items()
        }
        content = {
            'name': self.name,
            'command': self.command,
            'protocol': dict(self.protocol),
            'figures': figures,
        }
        path.write_text(json.dumps(content, indent=2, allow_nan=False) + '\n')

    def table(self) -> str:
        """Return the protocol and the figures as aligned lines."""
        rows = [(name, text_of(value)) for name, value in self.figures.items()]
        name_width = max((len(name) for name, _ in rows), default=0)
        value_width = max((len(value) for _, value in rows), default=0)
        lines = [f'  {name:<{name_width}}  {value:>{value_width}}' for name, value in rows]
        protocol = [f'  {name}: {value}' for name, value in self.protocol.items()]
        return '\n'.join([self.name, *protocol, '', *lines])


def machine() -> str:
    """Return the kind of machine: processors, system and Python, but not which one."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()
    python = platform.python_version()
    return f'{count} CPUs, {platform.system()} {platform.machine()}, Python {python}'


def text_of(value: float) -> str:
    """Return a figure as people read it: whole numbers whole, others with up to 3 decimals."""
    if not math.isfinite(value):
        return '-'
    if isinstance(value, int):
        return str(value)
    return f'{value:.3f}' if abs(value) < 10 else f'{value:.1f}'


def _plain(value: Any) -> float:
    """Return a Python number, whole where the value's type is."""
    if isinstance(value, bool) or not hasattr(value, '__float__'):
        raise TypeError(f'{value!r} is not a number')
    return int(value) if hasattr(value, '__index__') else float(value)
