"""Ticks rebuilt from the messages of a bag's cameras: detections, for example."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from mctrack_ros.config import ConfigError, config_from, of_chosen
from mctrack_ros.fusion import FUSION, FusionConfig, Joining, fusion_method, joined
from mctrack_ros.fusion.trackers import FusionMethod
from mctrack_ros.interfaces import (
    CameraRows,
    Detections,
    Events,
    Foreground,
    Message,
    RowsTick,
    Stamped,
    Ticks,
)
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.replay.camera_source import CameraResult
from mctrack_ros.replay.lockstep import Batches, in_order
from mctrack_ros.replay.quality import LEFT_OUT
from mctrack_ros.replay.stamps import Entry, judge
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.description import STATE
from mctrack_ros.site.site import SiteConfig

TICKS_TOPIC = '/ticks'
SITE_TOPIC = '/site'
EARLY_NS = 2_000_000_000
"""Time before a run of fusion began in which messages that it was given may have been logged."""
ALWAYS = (None, None)
Span = tuple[int | None, int | None]
"""Log times from which and until before which something is read, ns; None: all."""
CameraInput = tuple[int, str, Mapping[str, Message]]
"""Log time, ns, camera and its messages of an image, by topic."""


def recorded_ticks(
    reader: BagReader, cameras: tuple[str, ...], config: FusionConfig, span: Span = ALWAYS
) -> Iterator[RowsTick[Any]]:
    """
    Yield what fusion was given, in order.

    Where the bag holds ``/ticks`` these are just the messages that were admitted; else all, sorted
    into periods as the offline runner does.

    Parameters
    ----------
    reader : BagReader
        The bag, with ``<camera>/detections``, or what else the tracker takes.
    cameras : tuple of str
        Names in the site's order.
    config : FusionConfig
        Its period is used, and the kinds of message that its tracker takes.
    span : (int or None, int or None)
        When the ticks were logged, as `recorded_runs` says.

    Raises
    ------
    BagError
        If the bag holds none of these, or lacks some that were admitted.

    """
    period_ns, kinds = round(config.batching.period * 1e9), fusion_method(config).messages
    names = ' and '.join(kind.TOPIC for kind in kinds)
    present = [
        camera
        for camera in cameras
        if all(reader.count(f'/{camera}/{kind.TOPIC}') for kind in kinds)
    ]
    if not present:
        raise BagError(
            f'{reader.path} holds no {names} of {", ".join(cameras)}: track it first '
            f'(mctrack track), or record /<camera>/{kinds[0].TOPIC}'
        )
    begin_ns, end_ns = span
    early_ns = None if begin_ns is None else begin_ns - EARLY_NS
    has_ticks = reader.count(TICKS_TOPIC) > 0  # these say what was admitted: that must be there
    parts = [
        (time_ns, camera, part)
        for camera in present
        for kind in kinds
        for part, time_ns in reader.rows(
            f'/{camera}/{kind.TOPIC}', kind, early_ns, end_ns, usable=has_ticks
        )
    ]
    parts.sort(key=lambda part: part[0])
    joining = Joining(config)
    messages = [
        (time_ns, camera, whole)
        for time_ns, camera, part in parts
        if (whole := joining.add(camera, part)) is not None
    ]
    if has_ticks:
        records = [rows for rows, _ in reader.rows(TICKS_TOPIC, Ticks, *span)]
        yield from _admitted(records, messages, cameras, period_ns, reader, fusion_method(config))
    else:
        yield from _judged(messages, cameras, config)


def holds_masks(reader: BagReader, camera: str) -> bool:
    """Return whether a bag holds what every tracker takes of a camera: masks, too."""
    return all(reader.count(f'/{camera}/{kind.TOPIC}') for kind in (Detections, Foreground))


def recorded_settings(
    reader: BagReader, site: SiteConfig | None
) -> tuple[tuple[str, ...], FusionConfig]:
    """
    Return the cameras' names and how fusion was set: as a site says, else as the bag's ``/site``.

    A site that names no tracker has that which `mctrack track` chooses.

    Raises
    ------
    ConfigError
        If neither says it, or the site has other cameras than the bag.

    """
    said: Mapping[str, Any] = next((said for said, _ in recorded_runs(reader)), {})
    if site is not None:
        cameras = tuple(said.get('cameras', site.camera_names))
        if site.camera_names != cameras:
            raise ConfigError(
                f'{reader.path} was made by the cameras {", ".join(cameras)}; '
                f'the site has {", ".join(site.camera_names)}'
            )
        own_detections = not all(holds_masks(reader, camera) for camera in cameras)
        return cameras, with_tracker(site, own_detections)[0].fusion
    if 'fusion' not in said:
        raise ConfigError(
            f'{reader.path} does not say how fusion was set: name the site, for example '
            '--site pitch5'
        )
    return settings_of(said)


def settings_of(said: Mapping[str, Any]) -> tuple[tuple[str, ...], FusionConfig]:
    """Return the cameras' names and how fusion was set, of what ``/site`` says."""
    return tuple(said['cameras']), config_from(FUSION, of_chosen(FUSION, said['fusion']))


def recorded_runs(reader: BagReader) -> list[tuple[Mapping[str, Any], Span]]:
    """
    Return what ``/site`` says of each run of fusion, and when its ticks were logged.

    One that goes on after a restart, or with other parameters, begins with a state.
    """
    runs: list[tuple[int, Mapping[str, Any]]] = []
    last: Mapping[str, Any] = {}
    if reader.count(SITE_TOPIC):
        for _, message, time_ns in reader.messages([SITE_TOPIC]):
            said = json.loads(message.data)
            if not runs or any(said.get(key) != last.get(key) for key in ('run', STATE)):
                last = said
                runs.append((time_ns, said))
    bounds = [None, *(time_ns for time_ns, _ in runs[1:]), None]
    return [(said, span) for (_, said), span in zip(runs, pairwise(bounds))]


def _judged(
    messages: Sequence[CameraInput], cameras: tuple[str, ...], config: FusionConfig
) -> Iterator[RowsTick[Any]]:
    """Yield ticks as the offline runner makes them, from plausible stamps."""
    period_ns, batches = round(config.batching.period * 1e9), Batches(config, cameras)
    entries = [Entry(camera, _stamp_ns(parts), time_ns) for time_ns, camera, parts in messages]
    judged = {
        camera: iter(zip(stamps.stamp_ns, stamps.session))
        for camera, stamps in judge(entries, cameras, config.batching)[0].items()
    }
    periods: dict[int, list[CameraResult]] = defaultdict(list)
    for _, camera, parts in messages:
        stamp_ns, session = next(judged[camera])
        if stamp_ns != LEFT_OUT:
            events = Events.build(stamp_ns)
            restamped = {topic: part.at(stamp_ns) for topic, part in parts.items()}
            result = CameraResult(camera, restamped, events, False, session)
            periods[result.tick(period_ns)].append(result)
    for index in sorted(periods):
        yield from batches.ticks(in_order(periods[index]))


def _admitted(
    records: list[Ticks],
    messages: Sequence[CameraInput],
    cameras: tuple[str, ...],
    period_ns: int,
    reader: BagReader,
    method: FusionMethod,
) -> Iterator[RowsTick[Any]]:
    """Yield the recorded ticks, each message with the stamp that fusion gave it."""
    waiting: dict[tuple[str, int], list[Stamped]] = defaultdict(list)
    for _, camera, parts in messages:
        rows = joined(method, parts)
        waiting[camera, rows.stamp_ns // period_ns].append(rows)
    for record in records:
        if record.camera.max(initial=0) >= len(cameras):
            raise BagError(
                f'{reader.path} was recorded with more cameras than the site has: '
                f'{", ".join(cameras)}'
            )
        frames = []
        columns = record.camera, record.admitted, record.added_ms, record.age_us
        for camera, count, added_ms, age_us in zip(*(each.tolist() for each in columns)):
            name, added_ns = cameras[camera], added_ms * 1_000_000
            begin_ns = record.stamp_ns // period_ns * period_ns - added_ns
            stores = [waiting[name, (begin_ns + at) // period_ns] for at in (0, period_ns - 1)]
            stores = stores[: 1 + (stores[0] is not stores[1])]
            found = [
                (store, rows)
                for store in stores
                for rows in store
                if begin_ns <= rows.stamp_ns < begin_ns + period_ns
            ]
            first_ns = record.stamp_ns - age_us * 1000 - added_ns
            first = next(
                (at for at, (_, one) in enumerate(found) if 0 <= first_ns - one.stamp_ns < 1000), 0
            )
            if len(found) - first < count:
                topics = ' and '.join(kind.TOPIC for kind in method.messages)
                raise BagError(
                    f'{reader.path} lacks {topics} of {name} that were fused at '
                    f'{record.stamp_ns * 1e-9:.3f} s: it cannot be replayed'
                )
            for store, rows in found[first : first + count]:
                store.remove(rows)
                frames.append(CameraRows(name, rows.at(rows.stamp_ns + added_ns)))
        frames.sort(key=lambda frame: (frame.camera, frame.rows.stamp_ns))
        yield RowsTick(record.stamp_ns, tuple(frames), record)


def _stamp_ns(parts: Mapping[str, Message]) -> int:
    """Return the stamp of the image that messages are of, ns."""
    return next(iter(parts.values())).stamp_ns
