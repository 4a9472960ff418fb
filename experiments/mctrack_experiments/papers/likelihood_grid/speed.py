"""How many sets of four images one core takes a second."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from mctrack_ros.fusion import open_fusion
from mctrack_ros.fusion.inputs import GridInput
from mctrack_ros.fusion.likelihood_grid.config import LikelihoodGridConfig
from mctrack_ros.interfaces import CameraRows, Detections, Foreground, Likelihood, RowsTick
from mctrack_ros.perception.likelihood_grid.config import LikelihoodCameraConfig
from mctrack_ros.perception.likelihood_grid.edges import EdgeBackground, gradient_of
from mctrack_ros.perception.likelihood_grid.oriented_distance import OrientedDistance
from mctrack_ros.perception.likelihood_grid.pipeline import LikelihoodCamera, grid_of
from mctrack_ros.perception.likelihood_grid.templates import TemplateHierarchy
from mctrack_ros.replay.drive import drive
from mctrack_ros.simulation import INDOOR, IndoorScenario
from mctrack_ros.simulation.indoor.scenario import EMPTY_STEPS
from mctrack_ros.site.site import SiteConfig

FIRST, MEASURED = 200, 60
"""Steps of the scenario that are measured: everybody is there."""
Image = Any


def sets_a_second(scenario: IndoorScenario, site: SiteConfig) -> dict[str, float]:
    """Return the sets a second from edge maps, from images by edges alone, and by both layers."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        world = INDOOR.world(scenario)
        renderers = [INDOOR.renderer(world, index) for index in range(len(world.cameras))]
        steps = [*range(EMPTY_STEPS), *range(FIRST, FIRST + MEASURED)]
        sets = [[renderer.frame(step)[0] for renderer in renderers] for step in steps]
        stamps = [scenario.stamp_ns(step) for step in steps]
        return {
            'speed.edge_maps': 1 / _from_edges(sets, stamps, site),
            'speed.images': 1 / _from_images(sets, stamps, site, 'edges'),
            'speed.images_both': 1 / _from_images(sets, stamps, site, 'both'),
        }
    finally:
        cv2.setNumThreads(threads)


def _config(site: SiteConfig, layers: str) -> LikelihoodGridConfig:
    assert isinstance(site.fusion, LikelihoodGridConfig)
    return replace(site.fusion, layers=layers)


def _from_images(
    sets: list[list[Image]], stamps: list[int], site: SiteConfig, layers: str
) -> float:
    """Return the seconds a set takes all cameras and fusion."""
    cameras = {}
    for name, settings in site.cameras.items():
        assert isinstance(settings.pipeline, LikelihoodCameraConfig)
        pipeline = replace(settings.pipeline, foreground=layers == 'both')
        cameras[name] = LikelihoodCamera(pipeline, settings.mapping())
    feedback: Any = None

    def ticks() -> Iterator[RowsTick[GridInput]]:
        for images, stamp_ns in zip(sets, stamps):
            messages = []
            for (name, camera), image in zip(cameras.items(), images):
                told = camera.step(image, stamp_ns, feedback).messages
                parts = (told[kind.TOPIC] for kind in (Detections, Likelihood, Foreground))
                messages.append(CameraRows(name, GridInput(*parts)))  # type: ignore[arg-type]
            yield RowsTick.of(messages)

    done_s = []
    for ticked in drive(_config(site, layers), site.camera_names, ticks(), views=site.views):
        feedback = ticked.feedback
        done_s.append(time.process_time())
    return float(np.mean(np.diff(done_s)[-MEASURED // 2 :]))


def _from_edges(sets: list[list[Image]], stamps: list[int], site: SiteConfig) -> float:
    """Return the seconds a set takes from its edge maps on."""
    parts = []
    for index, settings in enumerate(site.cameras.values()):
        assert isinstance(settings.pipeline, LikelihoodCameraConfig)
        config, mapping = settings.pipeline.grid, settings.mapping()
        camera = LikelihoodCamera(settings.pipeline, mapping)
        background, grid = EdgeBackground(), grid_of(config)
        small = [camera.reduced(images[index]) for images in sets]
        for image in small[:EMPTY_STEPS]:
            if not background.is_learned:
                background.learn(gradient_of(image))
        size = small[0].shape[1], small[0].shape[0]
        edges = [background.foreground(gradient_of(image)) for image in small[EMPTY_STEPS:]]
        person = config.person_height, config.person_width
        templates = TemplateHierarchy(mapping, size, grid, *person, config.shape)
        place = grid.centres()
        position = np.column_stack([place, np.zeros(len(place))]).astype(np.float32)
        parts.append((edges, OrientedDistance(size), templates, position))
    tracker = open_fusion(_config(site, 'edges'), site.camera_names)
    begun_s = time.process_time()
    for row, stamp_ns in enumerate(stamps[EMPTY_STEPS:]):
        messages = []
        for name, (edges, distance, templates, position) in zip(site.cameras, parts):
            told = templates.log_likelihood(distance.transform(edges[row]))
            likelihood = Likelihood(stamp_ns, position, told)
            none = Detections.build(stamp_ns), Foreground.build(stamp_ns)
            messages.append(CameraRows(name, GridInput(none[0], likelihood, none[1])))
        tracker.step(RowsTick.of(messages))
    return (time.process_time() - begun_s) / MEASURED
