"""Nodes and commands as actions of `launch`; the launch files are made of these."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from mctrack_ros.resources import config_file
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec, truth_of
from mctrack_ros.ros.graph.supervise import BAD_CONFIGURATION
from mctrack_ros.site.names import namespace_of

Arguments = Mapping[str, tuple[str | None, str]]
"""Default, None where it must be given, and description of each argument."""
Values = Mapping[str, str]


def described(arguments: Arguments, specs: Callable[[Values], tuple[list[NodeSpec], str]]) -> Any:
    """
    Return the launch description of nodes.

    Parameters
    ----------
    arguments : Arguments
        Of the file, with all of `GRAPH` that make sense for it.
    specs : callable
        From their values to the nodes, and a line for the user.

    """
    from launch.actions import OpaqueFunction, SetEnvironmentVariable

    from launch import LaunchDescription

    def act(context: Any) -> list[Any]:
        values = _performed(arguments, context)
        return _actions(*specs(values), values)

    variables = [SetEnvironmentVariable(name, value) for name, value in ENVIRONMENT.items()]
    return LaunchDescription([*_declared(arguments), *variables, OpaqueFunction(function=act)])


def described_command(arguments: Arguments, command: Callable[[Values], list[str]]) -> Any:
    """Return the launch description of a command, by the values of its arguments."""
    from launch.actions import ExecuteProcess, OpaqueFunction

    from launch import LaunchDescription

    def act(context: Any) -> list[Any]:
        return [ExecuteProcess(cmd=command(_performed(arguments, context)), output='screen')]

    return LaunchDescription([*_declared(arguments), OpaqueFunction(function=act)])


def _declared(arguments: Arguments) -> list[Any]:
    from launch.actions import DeclareLaunchArgument

    return [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in arguments.items()
    ]


def _performed(arguments: Arguments, context: Any) -> dict[str, str]:
    from launch.substitutions import LaunchConfiguration

    return {name: str(LaunchConfiguration(name).perform(context)) for name in arguments}


def _actions(specs: list[NodeSpec], why: str, values: Values) -> list[Any]:
    """
    Return the actions that start nodes.

    The launch ends with a node that ends the graph, and with one whose configuration is wrong: no
    further start would help.
    """
    from launch.actions import LogInfo
    from launch.logging import launch_config
    from launch_ros.actions import Node

    respawn, is_on = (truth_of(name, values[name]) for name in ('respawn', 'autostart'))
    namespace = namespace_of(values['namespace'])
    directory = Path(launch_config.log_dir) / namespace.strip('/').replace('/', '_')
    directory.mkdir(parents=True, exist_ok=True)
    started = {} if is_on else {'autostart': False}
    more = [values['params_file']] if values['params_file'] else []
    made: list[Any] = [LogInfo(msg=why)] if why else []
    for spec in specs:
        written = replace(spec, parameters={**spec.parameters, **started}).write(directory)
        made.append(
            Node(
                package='mctrack_ros',
                executable=spec.executable,
                name=spec.name,
                namespace=namespace,
                parameters=[str(written), *more],
                ros_arguments=['--log-level', values['log_level']],
                respawn=respawn and spec.restart,
                respawn_delay=1.0,
                on_exit=partial(_after, spec),
                output='screen',
            )
        )
    if truth_of('rviz', values['rviz']):
        view = config_file('mctrack.rviz')
        made.append(
            Node(
                package='rviz2',
                executable='rviz2',
                namespace=namespace,
                arguments=['-d', str(view)],
                parameters=[{'use_sim_time': bool(specs[0].parameters.get('use_sim_time'))}],
                remappings=moved_topics(view.read_text('utf-8'), namespace),
            )
        )
    return made


def moved_topics(view: str, namespace: str) -> list[tuple[str, str]]:
    """Return the topics that a view of RViz shows, and their names in a namespace."""
    topics = ['/tf', '/tf_static', *re.findall(r'Value: (/\S+)', view)] if namespace else []
    return [(topic, f'{namespace}{topic}') for topic in topics]


def _after(spec: NodeSpec, event: Any, _: Any) -> list[Any]:
    """Return what follows the end of a node's process."""
    from launch.actions import Shutdown

    if event.returncode == BAD_CONFIGURATION:
        return [Shutdown(reason=f'{spec.name} cannot start: see what it says')]
    return [Shutdown()] if spec.ends else []
