"""Render a simulated scene into a bag: images of all cameras, and the truth."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.interfaces import code_tables
from mctrack_ros.processes import end_with_parent
from mctrack_ros.recording import ROSBAGS_CLASSES, BagError, BagWriter, check_place
from mctrack_ros.simulation import (
    Camera,
    EventWatcher,
    Figured,
    PtzCamera,
    Renderer,
    Scenario,
    View,
    World,
    parked_detections,
    parked_tracks,
    scene_of,
    true_detections,
    true_tracks,
)

GROUND_FRAME = 'map'
_CHUNK = 25
_JPEG_QUALITY = 90

Frames = list[tuple[NDArray[np.uint8], View]]
Progress = Callable[[int, int], None]


def simulate(
    scenario: Scenario,
    path: str | Path,
    *,
    world: World | None = None,
    processes: int | None = None,
    overwrite: bool = False,
    progress: Progress = lambda done, total: None,
) -> Figured:
    """
    Render a scenario into a bag; the same scenario gives the same bytes.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    path : str or Path
        The bag. It appears when it is complete; an interrupted run leaves nothing.
    world : World, optional
        What goes on; unless given, what follows from the scenario.
    processes : int, optional
        How many render; all cores unless given. The bytes do not depend on it.
    overwrite : bool
        Whether a bag already there is replaced.
    progress : callable
        Told how many periods of how many are done.

    Returns
    -------
    Figured
        How hard it is.

    Raises
    ------
    BagError
        If the bag cannot be written.

    """
    path = Path(path).absolute()
    check_place(path, overwrite)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f'.{path.name}.', dir=path.parent) as folder:
            unfinished = Path(folder) / path.name
            goes_on = world or scene_of(scenario).world(scenario)
            difficulty = _write(goes_on, unfinished, processes or os.cpu_count() or 1, progress)
            if path.exists():
                shutil.rmtree(path)
            unfinished.rename(path)
    except OSError as error:
        raise BagError(f'{path} cannot be written: {error}') from error
    return difficulty


def _write(world: World, path: Path, processes: int, progress: Progress) -> Figured:
    scenario = world.scenario
    meter = scene_of(scenario).meter(world)
    watchers = [EventWatcher(world, index) for index in range(len(world.cameras))]
    has_parked = bool(world.parked.any())
    with BagWriter(path) as bag:
        bag.write_text('/site', _site(world), scenario.start_ns)
        for step, images in enumerate(_rendered(world, processes)):
            bag.write_rows('/truth/tracks', true_tracks(world, step), GROUND_FRAME)
            if has_parked:
                bag.write_rows('/truth/parked', parked_tracks(world, step), GROUND_FRAME)
            for camera, watcher, (jpeg, view) in zip(world.cameras, watchers, images):
                events = watcher.step(step, view)
                meter.add(view, events)
                _write_image(bag, camera.name, jpeg, scenario.stamp_ns(step))
                truth = f'/truth/{camera.name}'
                if isinstance(camera, PtzCamera):
                    text = true_calibration(camera.at(step), scenario.stamp_ns(step))
                    bag.write_text(f'{truth}/calibration', text, scenario.stamp_ns(step))
                rows = true_detections(world, step, view)
                bag.write_rows(f'{truth}/detections', rows, GROUND_FRAME)
                if len(events):
                    bag.write_rows(f'{truth}/events', events, GROUND_FRAME)
                if has_parked:
                    rows = parked_detections(world, step, view)
                    bag.write_rows(f'{truth}/parked', rows, GROUND_FRAME)
            progress(step + 1, scenario.steps)
    return meter.result()


def _write_image(bag: BagWriter, camera: str, jpeg: NDArray[np.uint8], stamp_ns: int) -> None:
    message = compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, f'{camera}_optical_frame')
    bag.write(f'/{camera}/image_raw/compressed', message, stamp_ns)


def true_calibration(camera: Camera, stamp_ns: int) -> str:
    """Return the truth about one image of a camera that moves."""
    values = {'stamp': stamp_ns, 'image_from_world': camera.matrix.tolist(), 'size': camera.size}
    return json.dumps(values)


def _site(world: World) -> str:
    """Return what is needed to read the bag: cameras in order, codes, the scenario."""
    site: dict[str, Any] = {
        'layout': 1,
        'cameras': [camera.name for camera in world.cameras],
        'codes': code_tables(),
        'ground_frame': GROUND_FRAME,
        'scenario': asdict(world.scenario),
    }
    name = scene_of(world.scenario).name
    if name != 'pitch5':  # its bags do not name it, and stay what they were
        site['scene'] = name
    return json.dumps(site, sort_keys=True)


def _rendered(world: World, processes: int) -> Iterator[Frames]:
    """Yield, step by step, the images of all cameras; some chunks are rendered ahead."""
    cameras, steps = range(len(world.cameras)), world.scenario.steps
    spawned = multiprocessing.get_context('spawn')
    pending: deque[list[Future[Frames]]] = deque()
    with ProcessPoolExecutor(processes, spawned, _start_worker, (world,)) as pool:
        try:
            for first in range(0, steps, _CHUNK):
                last = min(first + _CHUNK, steps)
                pending.append([pool.submit(_chunk, camera, first, last) for camera in cameras])
                if len(pending) > 2:
                    yield from _together(pending.popleft())
            while pending:
                yield from _together(pending.popleft())
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _together(chunk: list[Future[Frames]]) -> Iterator[Frames]:
    for images in zip(*[future.result() for future in chunk]):
        yield list(images)


class _Worker:
    """What a rendering process keeps from chunk to chunk."""

    def __init__(self, world: World) -> None:
        cv2.setNumThreads(1)
        self._world = world
        self._renderers: dict[int, Renderer] = {}

    def chunk(self, camera: int, first: int, last: int) -> Frames:
        if camera not in self._renderers:
            self._renderers[camera] = scene_of(self._world.scenario).renderer(self._world, camera)
        frames = []
        for step in range(first, last):
            image, view = self._renderers[camera].frame(step)
            frames.append((jpeg_from_image(image, _JPEG_QUALITY), view))
        return frames


_workers: list[_Worker] = []


def _start_worker(world: World) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    end_with_parent()
    _workers.append(_Worker(world))


def _chunk(camera: int, first: int, last: int) -> Frames:
    return _workers[0].chunk(camera, first, last)
