"""The ticks of a bag again, from the detections that it holds."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator

from mctrack_ros.fusion import Batcher, FusionConfig
from mctrack_ros.interfaces import CameraDetections, Detections, Events, Tick, Ticks
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.replay.camera_source import CameraResult
from mctrack_ros.replay.lockstep import batched, in_order

TICKS_TOPIC = '/ticks'


def recorded_ticks(
    reader: BagReader, cameras: tuple[str, ...], config: FusionConfig
) -> Iterator[Tick]:
    """
    Yield what fusion was given, in order.

    Where the bag holds ``/ticks`` these are just the messages that were admitted; else all, sorted
    into periods as the offline runner does.

    Parameters
    ----------
    reader : BagReader
        The bag, with ``<camera>/detections``.
    cameras : tuple of str
        Names in the site's order.
    config : FusionConfig
        Its period is used.

    Raises
    ------
    BagError
        If the bag holds no detections, or lacks some that were admitted.

    """
    period_ns = round(config.batching.period * 1e9)
    periods: dict[int, list[CameraResult]] = defaultdict(list)
    present = [camera for camera in cameras if reader.count(f'/{camera}/detections')]
    if not present:
        raise BagError(
            f'{reader.path} holds no detections of {", ".join(cameras)}: track it first '
            '(mctrack track), or record /<camera>/detections'
        )
    for camera in present:
        for rows, _ in reader.rows(f'/{camera}/detections', Detections):
            events = Events.build(rows.stamp_ns)
            periods[rows.stamp_ns // period_ns].append(CameraResult(camera, rows, events, False))
    if reader.count(TICKS_TOPIC):
        records = [rows for rows, _ in reader.rows(TICKS_TOPIC, Ticks)]
        yield from _admitted(records, periods, cameras, period_ns, reader)
        return
    batcher = Batcher(config, cameras)
    for index in sorted(periods):
        yield from batched(batcher, in_order(periods[index]))


def _admitted(
    records: list[Ticks],
    periods: dict[int, list[CameraResult]],
    cameras: tuple[str, ...],
    period_ns: int,
    reader: BagReader,
) -> Iterator[Tick]:
    """Yield the ticks that were recorded: of each camera the first messages of the period."""
    for record in records:
        waiting = {camera: deque[Detections]() for camera in cameras}
        index = record.stamp_ns // period_ns
        for result in periods.pop(index, []):
            waiting[result.camera].append(result.detections)
        frames = []
        if record.camera.max(initial=0) >= len(cameras):
            raise BagError(
                f'{reader.path} was recorded with more cameras than the site has: '
                f'{", ".join(cameras)}'
            )
        for camera, count in zip(record.camera.tolist(), record.admitted.tolist()):
            name = cameras[camera]
            if len(waiting[name]) < count:
                raise BagError(
                    f'{reader.path} lacks detections of {name} that were fused at '
                    f'{record.stamp_ns * 1e-9:.3f} s: it cannot be replayed'
                )
            admitted = [waiting[name].popleft() for _ in range(count)]
            frames += [CameraDetections(name, rows) for rows in admitted]
        frames.sort(key=lambda frame: (frame.camera, frame.detections.stamp_ns))
        yield Tick(record.stamp_ns, tuple(frames), record)
