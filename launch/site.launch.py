"""Start the camera nodes, the fusion node, the coverage node and the store of a site."""

from dataclasses import replace
from pathlib import Path

from launch.actions import (
    DeclareLaunchArgument,
    LogInfo,
    OpaqueFunction,
    SetEnvironmentVariable,
)
from launch.logging import launch_config
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription
from mctrack_ros.cli.sites import site_path
from mctrack_ros.resources import config_file
from mctrack_ros.ros.graph.graph import ENVIRONMENT, coverage_node, stream_node, truth_of
from mctrack_ros.ros.graph.site_graph import site_nodes, store_node
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.names import namespace_of
from mctrack_ros.site.site import load_site


def site(context):
    values = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    truths = ('use_sim_time', 'respawn', 'autostart', 'rviz')
    simulated, respawn, autostart, rviz = (truth_of(name, values[name]) for name in truths)
    namespace = namespace_of(values['namespace'])
    path = site_path(values['site'])
    chosen, why = with_tracker(load_site(path))
    nodes = [*site_nodes(chosen, simulated), coverage_node(path, simulated)]
    if values['store']:
        nodes.append(store_node(values['store'], chosen, simulated))
    if values['stream']:
        nodes.append(stream_node(int(values['stream']), simulated, geo=chosen.geo))
    directory = Path(launch_config.log_dir) / namespace.strip('/').replace('/', '_')
    directory.mkdir(parents=True, exist_ok=True)
    given = [values['params_file']] if values['params_file'] else []
    first = [LogInfo(msg=why)] if why else []
    if rviz:
        first.append(_rviz(namespace, simulated))
    return first + [
        Node(
            package='mctrack_ros',
            executable=spec.executable,
            name=spec.name,
            namespace=namespace,
            parameters=[str(_started(spec, autostart).write(directory)), *given],
            ros_arguments=['--log-level', values['log_level']],
            respawn=respawn,
            respawn_delay=1.0,
            output='screen',
        )
        for spec in nodes
    ]


def _started(spec, autostart):
    """Return a node that starts itself, or waits for the lifecycle services."""
    return replace(spec, parameters={**spec.parameters, 'autostart': autostart})


def _rviz(namespace, simulated):
    return Node(
        package='rviz2',
        executable='rviz2',
        namespace=namespace,
        arguments=['-d', str(config_file('mctrack.rviz'))],
        parameters=[{'use_sim_time': simulated}],
    )


ARGUMENTS = {
    'site': 'site YAML, or the name of a shipped site',
    'namespace': 'namespace of all nodes',
    'params_file': 'ROS parameter file that is laid over the settings of the site; empty: none',
    'use_sim_time': 'whether time comes from /clock',
    'autostart': 'configure and activate the nodes; false: they wait for the lifecycle services',
    'log_level': 'least severity that is logged: debug, info, warn, error or fatal',
    'rviz': 'also start rviz2, where it is installed',
    'respawn': 'start again what dies',
    'stream': 'port of the node that gives tracks to other programs; empty: none',
    'store': 'trajectory database, a file or a URL; empty: none',
}
DEFAULTS = {
    'namespace': '',
    'params_file': '',
    'use_sim_time': 'false',
    'autostart': 'true',
    'log_level': 'info',
    'rviz': 'false',
    'respawn': 'true',
    'stream': '',
    'store': '',
}


def generate_launch_description():
    return LaunchDescription(
        [
            *[
                DeclareLaunchArgument(name, description=text, default_value=DEFAULTS.get(name))
                for name, text in ARGUMENTS.items()
            ],
            *[SetEnvironmentVariable(name, value) for name, value in ENVIRONMENT.items()],
            OpaqueFunction(function=site),
        ]
    )
