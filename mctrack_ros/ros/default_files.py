"""The shipped parameter files; ``python -m mctrack_ros.ros.default_files config`` writes them."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from mctrack_ros.config import Parameter, parameters_of
from mctrack_ros.ros.nodes.camera_node import CameraNodeConfig
from mctrack_ros.ros.nodes.coverage_node import CoverageNodeConfig
from mctrack_ros.ros.nodes.fusion_node import FusionNodeConfig
from mctrack_ros.ros.nodes.player import PlayerConfig
from mctrack_ros.ros.nodes.recorder import RecorderConfig
from mctrack_ros.ros.nodes.simulator_node import SimulatorNodeConfig
from mctrack_ros.ros.nodes.video_node import VideoNodeConfig

NODE_CONFIGS: dict[str, type[Any]] = {
    'camera_node': CameraNodeConfig,
    'fusion_node': FusionNodeConfig,
    'coverage_node': CoverageNodeConfig,
    'video_node': VideoNodeConfig,
    'simulator_node': SimulatorNodeConfig,
    'recorder': RecorderConfig,
    'player': PlayerConfig,
}
"""What configures a node, by its executable."""

_WIDTH = 95


def default_text(node: str) -> str:
    """Return a node's parameter file: every parameter with its default, unit and range."""
    kind = NODE_CONFIGS[node]
    summary = str(sys.modules[kind.__module__].__doc__).strip().splitlines()[0]
    lines = [f'# {summary}', '# Every parameter with its default.', '/**:', '  ros__parameters:']
    section: tuple[str, ...] = ()
    for parameter in parameters_of(kind):
        *parents, leaf = parameter.name.split('.')
        shared = 0
        while shared < len(parents) and parents[: shared + 1] == list(section[: shared + 1]):
            shared += 1
        for depth in range(shared, len(parents)):
            lines.append('  ' * (2 + depth) + parents[depth] + ':')
        section = tuple(parents)
        indent = '  ' * (2 + len(parents))
        lines += _comment(parameter, indent)
        lines.append(f'{indent}{leaf}: {yaml_text(parameter.default)}')
    return '\n'.join(lines) + '\n'


def write_defaults(directory: Path) -> Iterator[Path]:
    """Write the parameter file of every node; yield its path."""
    for node in NODE_CONFIGS:
        path = directory / f'{node}.yaml'
        path.write_text(default_text(node), encoding='utf-8')
        yield path


def yaml_text(value: Any) -> str:
    """Return a value as YAML writes it in one line."""
    plain = list(value) if isinstance(value, tuple) else value
    return yaml.safe_dump(plain, default_flow_style=True, width=1000).removesuffix('...\n').strip()


def _comment(parameter: Parameter, indent: str) -> list[str]:
    start = indent + '# '
    return textwrap.wrap(
        parameter.explained(), _WIDTH, initial_indent=start, subsequent_indent=start
    )


if __name__ == '__main__':
    for written in write_defaults(Path(sys.argv[1])):
        print(written)
