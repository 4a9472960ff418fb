"""What recording costs, and how well the player keeps time."""

from __future__ import annotations

import json
import os
import random
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mctrack_ros.cli.sites import named_site
from mctrack_ros.codec import compressed_message
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.recording import ROSBAGS_CLASSES, BagReader, BagWriter, attachments
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.recording.bags.qos import reliable
from mctrack_ros.recording.track_log.log import RECORDING
from mctrack_ros.replay.track import track_bag
from mctrack_ros.ros.graph.graph import ENVIRONMENT, player_node, recorder_node
from mctrack_ros.ros.graph.supervise import Supervisor

PERIOD_NS = 40_000_000
IMAGE_BYTES = 60_000
BEGIN_NS = 1_700_000_000 * 10**9
_LOOK_S = 0.5
_PLAYED = '/(cam.*|tracks|ticks|events|feedback|site)'


def bench_recording(bag: Path, seconds: float = 20.0) -> Figures:
    """
    Play five cameras at 25 Hz with all that the graph publishes, and record it.

    The recorder writes down when DDS received each message: the same bag says what was lost and
    how well the player kept the spacing of messages.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch; what fusion makes of them is played, too.
    seconds : float
        Length of what is played, s.

    """
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        place = Path(folder)
        played, recorded = place / 'played', place / 'recorded'
        track_bag(bag, place / 'out', named_site('pitch5'), processes=1)
        _write(place / 'out/bag', played, seconds)
        share = _record(played, recorded)
        counts = json.loads(attachments(recorded)[RECORDING])
        lost = sum(each['lost'] for each in counts.values())
        errors_ms = np.concatenate(list(_spacing_errors_ms(played, recorded)))
        with BagReader(played) as sent, BagReader(recorded) as came:
            missing = sum(sent.count(topic) - came.count(topic) for topic in sent.topics)
            messages = sum(map(sent.count, sent.topics))
        size_mb = sum(each.stat().st_size for each in recorded.iterdir()) / 1e6
    figures = {
        'recorder.core_share': share,
        'recorder.lost': lost,
        'recorder.missing': missing,
        'recorder.messages': messages,
        'recorder.mb': size_mb,
        'player.spacing_p50_ms': float(np.percentile(errors_ms, 50)),
        'player.spacing_p99_ms': float(np.percentile(errors_ms, 99)),
    }
    protocol = {
        'played': f'{seconds:g} s of five cameras at 25 Hz, images of {IMAGE_BYTES} bytes, with '
        'detections, tracks, ticks, events, feedback',
        'spacing': "between a topic's messages as DDS received them, from that in the bag",
        'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
    }
    return Figures('bench_recording', 'mctrack bench recording', protocol, figures)


def _write(tracked: Path, out: Path, seconds: float) -> None:
    """Write images of noise, which pack as badly as JPEG, and a run again and again."""
    kind = 'sensor_msgs/msg/CompressedImage'
    with BagReader(tracked) as reader, BagWriter(out) as writer:
        items = list(reader.serialized())
        first_ns, span_ns = items[0][3], round(reader.duration_s * 1e9) + PERIOD_NS
        told = [
            (
                BEGIN_NS + time_ns - first_ns + turn * span_ns + PERIOD_NS // 2,
                topic,
                its_kind,
                data,
            )
            for turn in range(int(seconds * 1e9 / span_ns) + 1)
            for topic, its_kind, data, time_ns in items
            if topic != '/site' or not turn
        ]
        for index in range(round(seconds * 1e9 / PERIOD_NS)):
            stamp_ns = BEGIN_NS + index * PERIOD_NS
            for camera in range(1, 6):
                noise = random.Random(index * 5 + camera).randbytes(IMAGE_BYTES)
                jpeg = np.frombuffer(noise, np.uint8)
                message = compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, '')
                data = bytes(TYPES.serialize_cdr(message, kind))
                told.append((stamp_ns, f'/cam{camera}/image_raw/compressed', kind, data))
        end_ns = BEGIN_NS + round(seconds * 1e9)
        for time_ns, topic, its_kind, data in sorted(told, key=lambda each: each[:2]):
            if time_ns >= end_ns:
                break
            if topic.endswith('compressed'):
                writer.write_serialized(topic, its_kind, data, time_ns, offered=[reliable(8)])
            else:
                writer.write_copy(reader, topic, its_kind, data, time_ns)


def _record(played: Path, recorded: Path) -> float:
    """Play a bag and record it; return the recorder's share of a core while it does."""
    nodes = [
        recorder_node(recorded, [_PLAYED]),
        player_node(played, wait_for=['.*'], settle=4.0),
    ]
    used: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        processes = [node.process(Path(folder)) for node in nodes]
        supervisor = Supervisor(processes, print, ENVIRONMENT)
        over = threading.Event()

        def look() -> None:
            while not over.wait(_LOOK_S):
                number = supervisor.pids().get('recorder')
                if number is not None and _size(recorded) > IMAGE_BYTES:
                    used.append((time.monotonic(), _cpu_s(number)))

        watch = threading.Thread(target=look)
        watch.start()
        code = supervisor.run()
        over.set()
        watch.join()
    if code:
        raise RuntimeError('; '.join(supervisor.failures))
    middle = used[len(used) // 10 : -max(len(used) // 10, 4)]
    return (middle[-1][1] - middle[0][1]) / (middle[-1][0] - middle[0][0])


def _size(folder: Path) -> int:
    return sum(each.stat().st_size for each in folder.glob('*.mcap'))


def _cpu_s(process: int) -> float:
    """Return the processor time that a process has used, s."""
    fields = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def _spacing_errors_ms(played: Path, recorded: Path) -> Iterator[np.ndarray]:
    """Yield of each topic by how much the time between messages differs, ms."""
    sent, came = _times(played), _times(recorded)
    for topic, times in sent.items():
        if len(times) == len(came[topic]) > 1:
            yield np.abs(np.diff(came[topic]) - np.diff(times)) * 1e-6


def _times(bag: Path) -> dict[str, list[int]]:
    found: dict[str, list[int]] = defaultdict(list)
    with BagReader(bag) as reader:
        for topic, _, _, time_ns in reader.serialized():
            found[topic].append(time_ns)
    return found
