"""The nodes of a site: which, with which parameters; for `mctrack run` and launch alike."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from mctrack_ros.config import values_of
from mctrack_ros.ros.camera_node import CameraNodeConfig
from mctrack_ros.ros.fusion_node import FusionNodeConfig
from mctrack_ros.ros.supervise import Process
from mctrack_ros.site_config import SiteConfig

ENVIRONMENT = {'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1'}
"""One thread a process: more only get in one another's way."""


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
    restart, ends : bool
        As in `Process`.

    """

    executable: str
    name: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    restart: bool = True
    ends: bool = False

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
        module = f'mctrack_ros.ros.{self.executable}'
        # -P: the package that runs here, not one that lies in the current directory
        command = (sys.executable, '-P', '-m', module, *arguments)
        return Process(self.name, command, self.restart, self.ends)


def site_nodes(site: SiteConfig, use_sim_time: bool = False) -> list[NodeSpec]:
    """Return a camera node for every camera of a site, and the fusion node."""
    clock = {'use_sim_time': use_sim_time}
    fusion = FusionNodeConfig(
        cameras=site.camera_names, ground_frame=site.ground_frame, fusion=site.fusion
    )
    nodes = [NodeSpec('fusion_node', 'fusion', values_of(fusion) | clock)]
    for name, settings in site.cameras.items():
        camera = CameraNodeConfig(
            camera=name,
            ground_frame=site.ground_frame,
            period=site.fusion.batching.period,
            feedback_delay=site.feedback_delay,
            settings=settings,
        )
        nodes.append(NodeSpec('camera_node', f'{name}_camera', values_of(camera) | clock))
    return nodes


def coverage_node(path: str | Path, use_sim_time: bool = False) -> NodeSpec:
    """Return the node that says what the cameras of a site, a file, see."""
    site = str(Path(path).absolute())
    return NodeSpec('coverage_node', 'coverage', {'site': site, 'use_sim_time': use_sim_time})


def player_node(path: str | Path, **parameters: Any) -> NodeSpec:
    """Return the node that plays a bag; the graph ends with it."""
    return NodeSpec('player', 'player', {'path': str(path)} | parameters, False, True)


def recorder_node(path: str | Path, topics: Sequence[str], **parameters: Any) -> NodeSpec:
    """Return the node that records topics."""
    values = {'path': str(path), 'topics': list(topics)} | parameters
    return NodeSpec('recorder', 'recorder', values, False)


def awaited_topics(site: SiteConfig, recorded: bool) -> list[str]:
    """
    Return what a player waits for (its ``wait_for``) so that a site's graph loses nothing.

    Parameters
    ----------
    site : SiteConfig
        Whose nodes run.
    recorded : bool
        Whether a recorder takes all that the nodes publish.

    """
    cameras, extra = site.cameras, int(recorded)
    awaited = [f'/{name}/{settings.image_topic}' for name, settings in cameras.items()]
    awaited += [f'/{name}/detections {1 + extra}' for name in cameras]
    awaited.append(f'/feedback {len(cameras) + extra}')
    return awaited + (['/tracks', '/events', '/ticks'] if recorded else [])


def _plain(values: Any) -> Any:
    """Return nested values as YAML writes them: lists for tuples."""
    if isinstance(values, Mapping):
        return {name: _plain(value) for name, value in values.items()}
    return list(values) if isinstance(values, tuple) else values
