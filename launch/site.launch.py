"""Start the camera nodes, the fusion node, the coverage node and the store of a site."""

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
from mctrack_ros.ros.graph.graph import ENVIRONMENT, coverage_node, truth_of
from mctrack_ros.ros.graph.site_graph import site_nodes, store_node
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.names import namespace_of
from mctrack_ros.site.site import load_site


def site(context):
    values = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    simulated, respawn = (truth_of(name, values[name]) for name in ('use_sim_time', 'respawn'))
    namespace = namespace_of(values['namespace'])
    path = site_path(values['site'])
    chosen, why = with_tracker(load_site(path))
    nodes = [*site_nodes(chosen, simulated), coverage_node(path, simulated)]
    if values['store']:
        nodes.append(store_node(values['store'], chosen, simulated))
    directory = Path(launch_config.log_dir)
    reason = [LogInfo(msg=why)] if why else []
    return reason + [
        Node(
            package='mctrack_ros',
            executable=spec.executable,
            name=spec.name,
            namespace=namespace,
            parameters=[str(spec.write(directory))],
            respawn=respawn,
            respawn_delay=1.0,
            output='screen',
        )
        for spec in nodes
    ]


ARGUMENTS = {
    'site': 'site YAML, or the name of a shipped site',
    'namespace': 'namespace of all nodes',
    'use_sim_time': 'whether time comes from /clock',
    'respawn': 'start again what dies',
    'store': 'trajectory database, a file or a URL; empty: none',
}
DEFAULTS = {'namespace': '', 'use_sim_time': 'false', 'respawn': 'true', 'store': ''}


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
