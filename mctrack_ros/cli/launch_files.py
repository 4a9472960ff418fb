"""The launch files: their arguments, and which nodes they start by these."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from mctrack_ros.config import ConfigError
from mctrack_ros.interfaces import Detections, Feedback, Tracks
from mctrack_ros.ros.graph.graph import (
    NodeSpec,
    coverage_node,
    player_node,
    stream_node,
    truth_of,
)
from mctrack_ros.ros.graph.launch_actions import Arguments, Values
from mctrack_ros.ros.graph.site_graph import site_nodes, store_node
from mctrack_ros.site.names import named_image_topic, resolved

GRAPH: Arguments = {
    'namespace': ('', 'namespace of all nodes: several sites stand beside each other'),
    'params_file': ('', 'ROS parameter file that goes before what the site says; empty: none'),
    'use_sim_time': ('false', 'whether time comes from /clock'),
    'autostart': ('true', 'configure and activate the nodes; false: as the lifecycle is told'),
    'log_level': ('info', 'debug, info, warn, error or fatal'),
    'respawn': ('true', 'start again what dies'),
    'rviz': ('false', 'start RViz with the view that comes with the package'),
}
SITE: Arguments = {
    'site': (None, 'site YAML, or the name of a shipped site'),
    **GRAPH,
    'own_detections': ('false', 'no camera nodes: own detectors send <camera>/detections'),
    'store': ('', 'trajectory database, a file or a URL; empty: none'),
    'stream': ('', 'port on which other programs get the tracks; empty: none'),
}
REPLAY: Arguments = {
    **SITE,
    'use_sim_time': ('true', "whether time is the bag's; false: its stamps are shifted to now"),
    'bag': (None, 'bag with the images of the cameras; with own_detections, their detections'),
    'rate': ('1.0', 'speed; 1: as recorded'),
    'start': ('0.0', 'where in the bag to begin, s'),
    'loop': ('false', 'begin again at the end'),
}
SIMULATION: Arguments = {
    **{name: SITE[name] for name in SITE if name != 'own_detections'},
    'site': ('pitch5', 'shipped site whose scene is simulated'),
    'seed': ('1', 'the same seed gives the same scene'),
}
CALIBRATION: Arguments = {
    'source': (None, 'an image, a video or a bag of the camera, or live: the running graph'),
    'scene': (None, "scene XML: the points' names and metres"),
    'camera': (None, "the camera's name"),
    'out': (None, 'grid XML to write; an existing one is continued'),
    'topic': ('', 'topic of the images; found by its name unless given'),
    'port': ('8080', 'port of the page'),
}


def site_specs(values: Values) -> tuple[list[NodeSpec], str]:
    """Return the nodes of a site, and why its tracker is that one."""
    from mctrack_ros.cli.sites import site_path
    from mctrack_ros.site.choice import with_tracker
    from mctrack_ros.site.site import load_site

    path = site_path(values['site'])
    simulated, own = (truth_of(name, values[name]) for name in ('use_sim_time', 'own_detections'))
    site, why = with_tracker(load_site(path), own)
    nodes = site_nodes(site, simulated, own)
    if site.cameras:
        nodes.append(coverage_node(path, simulated))
    if values['store']:
        nodes.append(store_node(values['store'], site, simulated))
    if values['stream']:
        port = number_of('stream', values['stream'])
        nodes.append(stream_node(int(port), simulated, geo=site.geo))
    return nodes, why


def replay_specs(values: Values) -> tuple[list[NodeSpec], str]:
    """Return the nodes of a site and a player of what its cameras, or own detectors, recorded."""
    from mctrack_ros.cli.sites import named_site

    site = named_site(values['site'])
    nodes, why = site_specs(values)
    taken = [
        named_image_topic(name, one.boxes_topic or one.image_topic)
        for name, one in site.cameras.items()
    ]
    if truth_of('own_detections', values['own_detections']):
        kinds = (Detections.TOPIC, 'events')
        taken = [f'{name}/{kind}' for name in site.cameras for kind in kinds]
    taken += [f'{cell}/{kind}' for cell in site.cells for kind in (Tracks.TOPIC, Feedback.TOPIC)]
    topics = [re.escape(resolved(topic)) for topic in taken]
    player = player_node(
        Path(values['bag']).absolute(),
        topics=[*topics, '/truth/.*'],
        wait_for=[f'.*{topic}' for topic in topics],
        rate=number_of('rate', values['rate']),
        start=number_of('start', values['start']),
        loop=truth_of('loop', values['loop']),
        restamp=not truth_of('use_sim_time', values['use_sim_time']),
    )
    return [*nodes, player], why


def simulation_specs(values: Values) -> tuple[list[NodeSpec], str]:
    """
    Return the nodes of a shipped site, and its simulated cameras.

    Raises
    ------
    ConfigError
        If the site has no scene.

    """
    from mctrack_ros.cli.sites import shipped_sites
    from mctrack_ros.simulation.scenes import SCENES

    name = values['site']
    if name not in shipped_sites():
        names = ', '.join(shipped_sites())
        raise ConfigError(f'site is {name!r}, expected one that is simulated: {names}')
    nodes, why = site_specs({**values, 'own_detections': 'false'})
    scene = SCENES[name]
    scenario = scene.scenario(seed=int(number_of('seed', values['seed'])))
    simulator = {
        'scene': name,
        'cameras': [camera.name for camera in scene.cameras(scenario)],
        'seed': scenario.seed,
        'duration': scenario.duration_s,
        'rate': scenario.rate_hz,
        'noise': scenario.noise,
        'shadows': scenario.shadows,
        'distortion': scenario.distortion,
        'lighting_drift': scenario.lighting_drift,
        'use_sim_time': truth_of('use_sim_time', values['use_sim_time']),
    }
    return [*nodes, NodeSpec('simulator_node', 'simulator', simulator)], why


def calibrate_command(values: Values) -> list[str]:
    """Return the command that shows the page on which a camera is calibrated."""
    command = [sys.executable, '-P', '-m', 'mctrack_ros.cli.main', 'calibrate']
    command += [values['source'], values['scene']]
    for name in ('camera', 'out', 'topic', 'port'):
        command += [f'--{name}', values[name]]
    return command


def number_of(name: str, text: str) -> float:
    """
    Return the number that a launch argument holds.

    Raises
    ------
    ConfigError
        If it holds none; names the argument.

    """
    try:
        return float(text)
    except ValueError as error:
        raise ConfigError(f'{name} is {text!r}, expected a number') from error
