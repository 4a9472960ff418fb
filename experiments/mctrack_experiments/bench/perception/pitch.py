"""How many images of the pitch a second one camera takes on one core, and where time goes."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import compressed_message, image_from_message, jpeg_from_image
from mctrack_ros.interfaces import CameraDetections, Feedback, Tick
from mctrack_ros.perception import EventTrackerConfig, FeedbackBuffer
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.background.objects import objects_in
from mctrack_ros.perception.blobs.extraction import clean_mask, find_blobs
from mctrack_ros.perception.camera_shift.monitor import CameraShiftMonitor
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.lockstep import tick_ns
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import CameraRenderer, Scenario, World
from mctrack_ros.simulation.pitch.players import Motion
from mctrack_ros.simulation.rendering.appearance import Appearance
from mctrack_ros.simulation.world import feet_in_view
from mctrack_ros.site.site import load_site

Image = NDArray[np.uint8]
CAMERA = 'cam5'
WARM_UP = 50
"""Images before time counts: the background is learned and tracks begin."""


class PitchBench:
    """
    Images of one camera of the pitch, compressed, and what is timed on them.

    Parameters
    ----------
    matches : int
        So many matches, of 25 people each, are played on one pitch at once.
    images : int
        How many are timed, after `WARM_UP`.
    seed : int
        Of the first match.

    """

    def __init__(self, matches: int, images: int, seed: int) -> None:
        self._site = load_site(config_file('pitch5.yaml'))
        self._world = crowd(matches, WARM_UP + images, seed)
        scenario = self._world.scenario
        renderer = CameraRenderer(self._world, self._site.camera_names.index(CAMERA))
        self._messages, self._count = [], images
        for step in range(scenario.steps):
            jpeg = jpeg_from_image(renderer.frame(step)[0])
            stamp_ns = scenario.stamp_ns(step)
            self._messages.append(compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, CAMERA))

    def whole(self) -> dict[str, float]:
        """Return processor time of decoding and of all the rest, ms, and persons an image."""
        camera, clock, persons = self._site.cameras[CAMERA].open(CAMERA), Stopwatch(), 0
        buffer = FeedbackBuffer(*tick_ns(self._site))

        def ticks() -> Iterator[Tick]:
            nonlocal clock, persons
            for step, message in enumerate(self._messages):
                if step == WARM_UP:
                    clock, persons = Stopwatch(), 0
                with clock.on('decoding'):
                    image = image_from_message(message)
                stamp_ns = self._world.scenario.stamp_ns(step)
                feedback, _ = buffer.select(stamp_ns)
                with clock.on('camera'):
                    detections = camera.step(image, stamp_ns, feedback).detections
                persons += len(detections)
                yield Tick.of([CameraDetections(CAMERA, detections)])

        for ticked in drive(self._site.fusion, (CAMERA,), ticks()):
            assert isinstance(ticked.feedback, Feedback)
            buffer.push(ticked.feedback)
        return clock.ms(self._count) | {'persons': persons / self._count}

    def stages(self) -> dict[str, float]:
        """Return what background, blobs and camera_shift cost, each alone, ms an image."""
        settings = self._site.cameras[CAMERA]
        config, mapping = settings.pipeline, settings.mapping()
        assert isinstance(config, EventTrackerConfig)
        background, sizes = Background(config.background), SizeTable(mapping)
        camera_shift, clock = CameraShiftMonitor(config.camera_shift), Stopwatch()
        nobody = np.zeros(mapping.image_size[::-1], np.uint8)
        for step, message in enumerate(self._messages):
            if step == WARM_UP:
                clock = Stopwatch()
            image, stamp_ns = image_from_message(message), self._world.scenario.stamp_ns(step)
            with clock.on('camera_shift'):
                camera_shift.watch(image, stamp_ns)
            with clock.on('background'):
                raw = background.apply(image, stamp_ns)
            if raw is None:
                continue
            with clock.on('cleaning'):
                found, threshold = background.difference, background.threshold
                cleaned = clean_mask(raw, found, threshold, config.blobs)
            with clock.on('background'):
                assert background.model is not None
                mask = objects_in(image, background.model, cleaned)
                background.learn(image, mask, nobody, nobody, stamp_ns)
            with clock.on('blobs'):
                find_blobs(mask, background.difference, mapping, sizes, 1.0, config.blobs)
        return clock.ms(self._count)

    def peer(self, work: Callable[[Image], object]) -> float:
        """Return how many of the same images something else takes a second."""
        clock = Stopwatch()
        for step, message in enumerate(self._messages):
            if step == WARM_UP:
                clock = Stopwatch()
            image = image_from_message(message)
            with clock.on('peer'):
                work(image)
        return 1e3 / clock.ms(self._count)['peer_ms']


class Stopwatch:
    """Adds up the processor time of this thread under several names."""

    def __init__(self) -> None:
        self._spent_s: dict[str, float] = defaultdict(float)

    @contextmanager
    def on(self, name: str) -> Iterator[None]:
        """Count what is done inside under a name."""
        began = time.thread_time()
        yield
        self._spent_s[name] += time.thread_time() - began

    def ms(self, count: int) -> dict[str, float]:
        """Return the time of each name for one of so many, ms."""
        return {f'{name}_ms': 1e3 * spent / count for name, spent in self._spent_s.items()}


def crowd(matches: int, steps: int, seed: int) -> World:
    """Return several matches on one pitch at once, each of 25 people with a seed of its own."""
    rate_hz = Scenario().rate_hz
    worlds = [
        World.simulated(Scenario(seed=seed + match, duration_s=steps / rate_hz))
        for match in range(matches)
    ]
    motion = Motion(*(
        np.concatenate([getattr(world.motion, name) for world in worlds], axis=1)
        for name in ('position', 'velocity', 'heading', 'stride')
    ))  # fmt: skip
    appearance = Appearance(*(
        np.concatenate([getattr(world.appearance, name) for world in worlds])
        for name in ('palette', 'height', 'kit')
    ))  # fmt: skip
    active = np.ones(motion.heading.shape, np.bool_)
    return replace(
        worlds[0],
        motion=motion,
        appearance=appearance,
        feet_in_view=feet_in_view(motion.position, worlds[0].cameras),
        active=active,
        parked=~active,
        class_id=np.concatenate([world.class_id for world in worlds]),
    )


def bare_contours() -> Callable[[Image], object]:
    """Return the least that can be done: a fixed background, a threshold, contours."""
    first: list[Image] = []

    def work(image: Image) -> Sequence[object]:
        if not first:
            first.append(image)
        difference = cv2.cvtColor(cv2.absdiff(image, first[0]), cv2.COLOR_BGR2GRAY)
        _, mask = cv2.threshold(difference, 12, 255, cv2.THRESH_BINARY)
        return cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)

    return work


def mog2_contours() -> Callable[[Image], object]:
    """Return what is commonly done: OpenCV's mixture of Gaussians, opening, contours."""
    model = cv2.createBackgroundSubtractorMOG2(detectShadows=False)
    kernel = np.ones((3, 3), np.uint8)

    def work(image: Image) -> Sequence[object]:
        mask = cv2.morphologyEx(model.apply(image), cv2.MORPH_OPEN, kernel)
        return cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)

    return work
