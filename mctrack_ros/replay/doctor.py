"""What is wrong with a site, and with a bag for it, before it is tracked."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mctrack_ros.codec import image_from_message
from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import fusion_method
from mctrack_ros.ground import CalibrationError
from mctrack_ros.perception import ImageState, ImageWatch
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.replay.camera_source import CameraTask, topic_of
from mctrack_ros.replay.lockstep import ReplayError, tick_ns
from mctrack_ros.replay.quality import JUMP_REMEDY, CameraQuality, complaints, pace_complaint
from mctrack_ros.replay.stamps import (
    Entry,
    corrected,
    judge,
    logged_on_arrival,
    read_entries,
)
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.site import SiteConfig

SAMPLED = 8
"""Number of images of a camera that are checked."""


class Severity(StrEnum):
    """How bad a finding is."""

    ERROR = 'error'
    WARNING = 'warning'
    NOTE = 'note'


class Finding(NamedTuple):
    """
    Something that was found.

    Attributes
    ----------
    severity : Severity
        An error keeps the site from being tracked.
    about : str
        A camera, or the site.
    what, remedy : str
        What is wrong, and what to do.

    """

    severity: Severity
    about: str
    what: str
    remedy: str


def examine_site(site: SiteConfig) -> Iterator[Finding]:
    """Yield what is wrong with a site's files and settings."""
    try:
        tick_ns(site)
    except ReplayError as error:
        remedy = 'leave feedback_delay out: it is two periods then'
        yield Finding(Severity.ERROR, site.name, str(error), remedy)
    for name, camera in site.cameras.items():
        yield from _examine_camera(name, camera)


def _examine_camera(name: str, camera: CameraSettings) -> Iterator[Finding]:
    try:
        camera.open(name)
        doubt = camera.doubt()
    except (ConfigError, CalibrationError) as error:
        yield Finding(
            Severity.ERROR, name, str(error), 'correct the file or the key that it names'
        )
        return
    if doubt:
        remedy = 'calibrate again, or see whether that much matters'
        if camera.grid:
            remedy = f'look closer: mctrack check-calibration {camera.grid}'
        yield Finding(Severity.WARNING, name, f'its calibration is doubtful: {doubt}', remedy)
    if not camera.background:
        yield Finding(
            Severity.NOTE,
            name,
            'there is no image of the empty scene: the first seconds only teach the background, '
            'and whoever stands there is taken for it at first',
            'name one as background',
        )


def examine_bag(path: str | Path, site: SiteConfig, namespace: str = '') -> Iterator[Finding]:
    """Yield what is wrong with a bag that is to be tracked with a site."""
    if site.cells:
        what = 'it has cells, no cameras: no bag is tracked with it'
        yield Finding(Severity.ERROR, site.name, what, 'examine the site of each cell')
        return
    topics: dict[str, str] = {}
    kinds = fusion_method(site.fusion).messages
    tasks = [
        CameraTask(Path(path), *each, 1, 1, namespace, kinds=kinds)
        for each in site.cameras.items()
    ]
    with BagReader(path, namespace) as reader:
        for task in tasks:
            try:
                topics[topic_of(task, reader)] = task.camera
            except BagError as error:
                remedy = 'mend the name of the camera or its image_topic in the site'
                yield Finding(Severity.ERROR, task.camera, str(error), remedy)
        if not topics:
            return
        try:
            entries = read_entries(reader, topics, log_times=False)
        except BagError as error:
            yield Finding(Severity.ERROR, site.name, str(error), 'track with --log-times')
            return
        yield from _examine_stamps(corrected(entries, reader, topics, site), site)
        for task in tasks:
            if task.image_topic in topics:
                yield from _examine_images(reader, task, entries)


def _examine_stamps(entries: list[Entry], site: SiteConfig) -> Iterator[Finding]:
    """Check clocks, gaps and rates."""
    if not logged_on_arrival(entries):
        what = 'the times of recording do not show when messages came: clocks are not compared'
        yield Finding(Severity.NOTE, site.name, what, 'none is needed if all stamps are right')
    judged, jumps = judge(entries, site.camera_names, site.fusion.batching)
    for jump in jumps:
        yield Finding(Severity.WARNING, site.name, str(jump), JUMP_REMEDY)
    for name, stamps in judged.items():
        for line in complaints(CameraQuality(name), stamps, 0.0):
            what = line.removeprefix(f'{name}: ')
            remedy = "set the cameras' clocks by NTP or PTP, or see why messages get lost"
            yield Finding(Severity.WARNING, name, what, remedy)
    intervals = {name: stamps.interval_s() for name, stamps in judged.items()}
    if pace := pace_complaint(intervals, site.fusion.batching.period):
        yield Finding(Severity.WARNING, site.name, *pace)


def _examine_images(
    reader: BagReader, task: CameraTask, entries: list[Entry]
) -> Iterator[Finding]:
    """Check some images: their size, and whether they show anything."""
    count = sum(entry.camera == task.camera for entry in entries)
    wanted = set(np.linspace(0, count - 1, min(count, SAMPLED)).astype(int).tolist())
    settings, states = task.settings, []
    for index, (_, message, _) in enumerate(reader.messages([task.image_topic])):
        if index not in wanted:
            continue
        try:
            image = image_from_message(message, (settings.image_width, settings.image_height))
        except ValueError as error:
            remedy = 'set image_width and image_height, and calibrate for that size'
            yield Finding(Severity.ERROR, task.camera, f'image {index}: {error}', remedy)
            return
        states.append(ImageWatch().look(image, 0))
    bad = [state for state in states if state is not ImageState.USABLE]
    if bad:
        what = f'{len(bad)} of {len(states)} images that were looked at: {bad[0]}'
        yield Finding(Severity.WARNING, task.camera, what, 'look at them: mctrack echo, a player')
