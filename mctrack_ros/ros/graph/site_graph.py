"""The nodes that track what a site's cameras see, and what a player waits for to feed them."""

from __future__ import annotations

from pathlib import Path

from mctrack_ros.config import ConfigError, values_of
from mctrack_ros.fusion import fusion_method
from mctrack_ros.interfaces import Detections
from mctrack_ros.ros.graph.graph import NodeSpec
from mctrack_ros.ros.nodes.camera_node import CameraNodeConfig
from mctrack_ros.ros.nodes.fusion_node import FusionNodeConfig
from mctrack_ros.site.names import named_image_topic, resolved
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.site.stated_origin import origin_text


def site_nodes(
    site: SiteConfig, use_sim_time: bool = False, own_detections: bool = False
) -> list[NodeSpec]:
    """
    Return a site's fusion node and, but for own detections, a camera node for each camera.

    A site of cells has no cameras.

    Raises
    ------
    ConfigError
        If detections are own and the tracker takes more than these.

    """
    tracker = site.fusion.tracker
    if own_detections and not site.cells and fusion_method(site.fusion).messages != (Detections,):
        raise ConfigError(f'fusion.tracker {tracker} takes more than own detections: name joint')
    clock = {'use_sim_time': use_sim_time}
    fusion = FusionNodeConfig(
        cameras=site.camera_names,
        ground_frame=site.ground_frame,
        origin=origin_text(site.origin),
        site=site.path,
        private=site.private,
        clock_offsets=','.join(f'{name}={ahead}' for name, ahead in site.clock_offsets.items()),
        fusion=site.fusion,
    )
    nodes = [NodeSpec('fusion_node', 'fusion', values_of(fusion) | clock)]
    if own_detections:
        return nodes
    for name, settings in site.cameras.items():
        camera = CameraNodeConfig(
            camera=name,
            ground_frame=site.ground_frame,
            period=site.fusion.batching.period,
            feedback_delay=site.feedback_delay,
            private=site.private,
            blur=site.blur,
            settings=settings,
        )
        nodes.append(NodeSpec('camera_node', f'{name}_camera', values_of(camera) | clock))
    return nodes


def store_node(
    database: str | Path, site: SiteConfig, use_sim_time: bool = False, finish: bool = False
) -> NodeSpec:
    """Return the node that keeps what a site's nodes say in a database: a file, or a URL."""
    place = database if '://' in str(database) else Path(database).absolute()
    values = {
        'database': str(place),
        'site': site.name,
        'cameras': list(site.camera_names),
        'finish': finish,
        'use_sim_time': use_sim_time,
    }
    return NodeSpec('store_node', 'store', values)


def awaited_topics(site: SiteConfig, recorded: bool, stored: bool = False) -> list[str]:
    """
    Return what a player waits for (its ``wait_for``) so that a site's graph loses nothing.

    Parameters
    ----------
    site : SiteConfig
        Whose nodes run.
    recorded, stored : bool
        Whether a recorder takes all that the nodes publish, and a store what it keeps.

    """
    cameras, extra = site.cameras, int(recorded)
    awaited = [resolved(named_image_topic(name, one.image_topic)) for name, one in cameras.items()]
    method = fusion_method(site.fusion)
    awaited += [
        f'/{name}/{kind.TOPIC} {1 + extra}' for name in cameras for kind in method.messages
    ]
    awaited.append(f'/{method.feedback.TOPIC} {len(cameras) + extra}')
    if takers := extra + int(stored):
        awaited += [f'/tracks {takers}', f'/events {takers}']
        awaited += [f'/{name}/events {1 + takers}' for name in cameras if stored]
    return awaited + (['/ticks 1'] if recorded else [])
