"""Nodes to be run as processes, with their parameters; for `mctrack` and launch alike."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from mctrack_ros.config import ConfigError
from mctrack_ros.ros.graph.supervise import Process

ENVIRONMENT = {'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1'}
"""One thread a process: more only get in one another's way."""

_TRUTHS = {
    **dict.fromkeys(('true', 'yes', 'on', '1'), True),
    **dict.fromkeys(('false', 'no', 'off', '0'), False),
}
"""What YAML and launch take for true and false, in any case."""


@dataclass(frozen=True, slots=True)
class NodeSpec:
    """
    One node of a graph.

    Attributes
    ----------
    executable : str
        Of the package; a module of `mctrack_ros.ros`.
    name : str
        Name of the node.
    parameters : mapping
        Nested values.
    restart, ends, takes_keys : bool
        As in `Process`.

    """

    executable: str
    name: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    restart: bool = True
    ends: bool = False
    takes_keys: bool = False

    def write(self, directory: Path) -> Path:
        """Write the parameters as a ROS parameter file."""
        path = directory / f'{self.name}.yaml'
        content = {'/**': {'ros__parameters': _plain(self.parameters)}}
        path.write_text(yaml.safe_dump(content, sort_keys=False), encoding='utf-8')
        return path

    def process(self, directory: Path, namespace: str = '') -> Process:
        """Return the process that runs the node; its parameter file goes into a directory."""
        arguments = ['--ros-args', '-r', f'__node:={self.name}']
        if namespace:
            arguments += ['-r', f'__ns:={namespace}']
        arguments += ['--params-file', str(self.write(directory))]
        module = f'mctrack_ros.ros.nodes.{self.executable}'
        # -P: the package that runs here, not one that lies in the current directory
        command = (sys.executable, '-P', '-m', module, *arguments)
        return Process(self.name, command, self.restart, self.ends, self.takes_keys)


def truth_of(name: str, text: str) -> bool:
    """
    Return whether the text of a launch argument means true.

    Raises
    ------
    ConfigError
        If it means neither true nor false; names the argument.

    """
    truth = _TRUTHS.get(text.strip().lower())
    if truth is None:
        raise ConfigError(f'{name} is {text!r}, expected true or false')
    return truth


def coverage_node(path: str | Path, use_sim_time: bool = False) -> NodeSpec:
    """Return the node that says what the cameras of a site, a file, see."""
    site = str(Path(path).absolute())
    return NodeSpec('coverage_node', 'coverage', {'site': site, 'use_sim_time': use_sim_time})


def stream_node(port: int, use_sim_time: bool = False, **parameters: Any) -> NodeSpec:
    """Return the node that gives tracks and events to other media, on a port of this machine."""
    values = {'port': port, 'use_sim_time': use_sim_time} | parameters
    return NodeSpec('stream_node', 'stream', values)


def player_node(path: str | Path, **parameters: Any) -> NodeSpec:
    """Return the node that plays a bag; the graph ends with it."""
    return NodeSpec('player', 'player', {'path': str(path)} | parameters, False, True, True)


def recorder_node(path: str | Path, topics: Sequence[str], **parameters: Any) -> NodeSpec:
    """Return the node that records topics."""
    values = {'path': str(path), 'topics': list(topics)} | parameters
    return NodeSpec('recorder', 'recorder', values, False)


def _plain(values: Any) -> Any:
    """Return nested values as YAML writes them: lists for tuples."""
    if isinstance(values, Mapping):
        return {name: _plain(value) for name, value in values.items()}
    return list(values) if isinstance(values, tuple) else values
