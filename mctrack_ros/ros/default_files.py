"""
The shipped parameter files; ``python -m mctrack_ros.ros.default_files config`` writes them.

With ``--set NAME=METHOD``, ``--set settings.pipeline.local_tracker=silhouettes`` for example, the
files hold the parameters of that method instead of the default's.
"""

from __future__ import annotations

import argparse
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from mctrack_ros.config import ConfigError, Parameter, parameters_of
from mctrack_ros.ros.nodes.camera_node import CameraNodeConfig
from mctrack_ros.ros.nodes.coverage_node import CoverageNodeConfig
from mctrack_ros.ros.nodes.fusion_node import FusionNodeConfig
from mctrack_ros.ros.nodes.player import PlayerConfig
from mctrack_ros.ros.nodes.recorder import RecorderConfig
from mctrack_ros.ros.nodes.simulator_node import SimulatorNodeConfig
from mctrack_ros.ros.nodes.store_node import StoreNodeConfig
from mctrack_ros.ros.nodes.stream_node import StreamNodeConfig
from mctrack_ros.ros.nodes.video_node import VideoNodeConfig

NODE_CONFIGS: dict[str, type[Any]] = {
    'camera_node': CameraNodeConfig,
    'fusion_node': FusionNodeConfig,
    'coverage_node': CoverageNodeConfig,
    'stream_node': StreamNodeConfig,
    'store_node': StoreNodeConfig,
    'video_node': VideoNodeConfig,
    'simulator_node': SimulatorNodeConfig,
    'recorder': RecorderConfig,
    'player': PlayerConfig,
}
"""What configures a node, by its executable."""

_WIDTH = 95


def default_text(node: str, chosen: Mapping[str, str] | None = None) -> str:
    """
    Return a node's parameter file: every parameter with its default, unit and range.

    Parameters
    ----------
    node : str
        Executable of the node.
    chosen : mapping of str to str, optional
        Methods, by the parameter that names them, in place of the default ones.

    Raises
    ------
    ConfigError
        If a method does not exist.

    """
    chosen = chosen or {}
    kind = NODE_CONFIGS[node]
    summary = str(sys.modules[kind.__module__].__doc__).strip().splitlines()[0]
    parameters = list(parameters_of(kind, given=chosen))
    lines = [f'# {summary}', '# Every parameter with its default.']
    lines += _other_methods(parameters, chosen)
    lines += ['/**:', '  ros__parameters:']
    section: tuple[str, ...] = ()
    for parameter in parameters:
        *parents, leaf = parameter.name.split('.')
        shared = 0
        while shared < len(parents) and parents[: shared + 1] == list(section[: shared + 1]):
            shared += 1
        for depth in range(shared, len(parents)):
            lines.append('  ' * (2 + depth) + parents[depth] + ':')
        section = tuple(parents)
        indent = '  ' * (2 + len(parents))
        lines += _comment(parameter, indent)
        value = chosen.get(parameter.name, parameter.default)
        lines.append(f'{indent}{leaf}: {yaml_text(value)}')
    return '\n'.join(lines) + '\n'


def write_defaults(directory: Path, chosen: Mapping[str, str] | None = None) -> Iterator[Path]:
    """Write the parameter file of every node, see `default_text`; yield its path."""
    for node in NODE_CONFIGS:
        path = directory / f'{node}.yaml'
        path.write_text(default_text(node, chosen), encoding='utf-8')
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


def _other_methods(parameters: Sequence[Parameter], chosen: Mapping[str, str]) -> list[str]:
    """Return lines that say how to see the parameters of methods that are not shown."""
    tags = [each for each in parameters if each.is_tag and len(each.choices) > 1]
    if not tags:
        return []
    shown = chosen.get(tags[0].name, tags[0].default)
    other = next(each for each in tags[0].choices if each != shown)
    names = ' and '.join(tag.name for tag in tags)
    text = f'Of the methods of {names} only the parameters of the one that is named. For another:'
    return [
        *textwrap.wrap(text, _WIDTH, initial_indent='# ', subsequent_indent='# '),
        f'#   python -m mctrack_ros.ros.default_files /tmp --set {tags[0].name}={other}',
    ]


def main() -> int:
    """Write the files as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('directory', type=Path, help='where the files are written')
    parser.add_argument(
        '--set',
        action='append',
        default=[],
        metavar='NAME=METHOD',
        help='show the parameters of this method; may be given several times',
    )
    arguments = parser.parse_args()
    chosen = dict(each.partition('=')[::2] for each in arguments.set)
    try:
        known = [
            each for kind in NODE_CONFIGS.values() for each in parameters_of(kind, given=chosen)
        ]
        tags = [each.name for each in known if each.is_tag]
        for name in chosen.keys() - set(tags):
            raise ConfigError(f'{name or "nothing"} names no method: {" and ".join(tags)} do')
        for written in write_defaults(arguments.directory, chosen):
            print(written)
    except ConfigError as error:
        parser.error(str(error))
    return 0


if __name__ == '__main__':
    sys.exit(main())
