"""Whether a replay gives the same tracks whatever the order of arrival, and how fast it is."""

from __future__ import annotations

import os
import random
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mctrack_ros.cli.sites import named_site
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.recording import BagReader, BagWriter, attachments
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.recording.bags.mcap_file import McapFile
from mctrack_ros.recording.track_log.log import CLOUD, Canonical, StoredLog
from mctrack_ros.replay.proof.verify import verify_bag
from mctrack_ros.replay.track import track_bag
from mctrack_ros.simulation import SCENES
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import SiteConfig

SITE = 'pitch5'
PROCESSES = (1, 2, 3)


def bench_replay(
    bag: Path, replays: int = 100, flips: int = 20, picture_s: float = 12.0, seed: int = 1
) -> Figures:
    """
    Replay a bag in lock step again and again, its messages in another order of arrival each time.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch.
    replays : int
        How often, by one to three processes in turn.
    flips : int
        So many times one bit of one message is changed, and has to be found.
    picture_s : float
        Length of the rendered images, s; 0: none.
    seed : int
        Of orders, bits and images.

    """
    site, chance = named_site(SITE), random.Random(seed)
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        place = Path(folder)
        hashes = set()
        for index in range(replays):
            shuffled(bag, place / 'shuffled', site, chance)
            hashes.add(_tracked(place / 'shuffled', place / 'out', site, PROCESSES[index % 3]))
        track_bag(bag, place / 'out', site, processes=1, overwrite=True)
        verify_bag(place / 'out')  # compiles, unless that was done
        began_s = time.perf_counter()
        verdict, _ = verify_bag(place / 'out')
        figures = {
            'hashes': len(hashes),
            'replays': replays,
            'detections.realtime_factor': verdict.seconds / (time.perf_counter() - began_s),
            'flips': flips,
            'flips.found': sum(_is_found(place / 'out/bag', place, chance) for _ in range(flips)),
        }
        if picture_s:
            figures['pictures.realtime_factor'] = _picture_speed(place, site, picture_s, seed)
    protocol = {
        'bag': bag.name,
        'processes': '1, 2, 3 in turn',
        'order': "arrival up to max_wait after the stamp; each camera's messages keep theirs",
        'pictures': f'{picture_s:g} s of five cameras, two processes',
        'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
    }
    return Figures('bench_replay', 'mctrack bench replay', protocol, figures)


def shuffled(bag: Path, out: Path, site: SiteConfig, chance: random.Random) -> None:
    """Write a bag whose messages arrive late by chance, as long as fusion waits at most."""
    batching = site.fusion.batching
    wait_ns = round(batching.max_wait * batching.period * 1e9)
    last_ns: dict[str, int] = {}
    with BagReader(bag) as reader, BagWriter(out, overwrite=True) as writer:
        arrivals = []
        for topic, kind, data, time_ns in reader.serialized():
            due_ns = max(time_ns + chance.randrange(wait_ns), last_ns.get(topic, 0) + 1)
            last_ns[topic] = due_ns
            arrivals.append((due_ns, topic, kind, data))
        for due_ns, topic, kind, data in sorted(arrivals, key=lambda each: each[:2]):
            writer.write_copy(reader, topic, kind, data, due_ns)


def _tracked(bag: Path, out: Path, site: SiteConfig, processes: int) -> bytes:
    """Track a bag; return the hash of the tracks."""
    track_bag(bag, out, site, processes=processes, overwrite=True)
    return StoredLog.of(attachments(out / 'bag')).hashes['/tracks'][1]


def _picture_speed(place: Path, site: SiteConfig, seconds: float, seed: int) -> float:
    """Return how many times faster than real time images of five cameras are tracked."""
    scenario = SCENES['pitch5'].scenario(seed=seed, duration_s=seconds)
    simulate(scenario, place / 'images', processes=2)
    track_bag(place / 'images', place / 'out', site, processes=2, overwrite=True)
    began_s = time.perf_counter()
    summary = track_bag(place / 'images', place / 'out', site, processes=2, overwrite=True)
    return summary.bag_seconds / (time.perf_counter() - began_s)


def _is_found(bag: Path, place: Path, chance: random.Random) -> bool:
    """Change one bit of one field of one cloud; return whether just that is said to differ."""
    with BagReader(bag) as reader:
        clouds = [(n, each) for n, each in enumerate(reader.serialized()) if _fields(each)]
    number, (topic, kind, data, time_ns) = chance.choice(clouds)
    name = chance.choice(sorted(_fields((topic, kind, data, time_ns))))
    message: Any = TYPES.deserialize_cdr(data, kind)
    (field,) = (each for each in message.fields if each.name == name)
    size = len(Canonical.of(kind, data, time_ns).fields[name]) // (message.height * message.width)
    row, bit = chance.randrange(message.width), chance.randrange(8 * size)
    message.data = message.data.copy()
    message.data[row * message.point_step + field.offset + bit // 8] ^= 1 << bit % 8
    changed = bytes(TYPES.serialize_cdr(message, kind))
    path = place / 'changed.mcap'
    path.unlink(missing_ok=True)
    copy = McapFile(path, is_packed=False)
    for index, (each, content, at_ns) in enumerate(_copied(bag, copy)):
        copy.write(each, at_ns, changed if index == number else content)
    for attached, content in attachments(bag).items():
        copy.attach(attached, '', content, 0)
    copy.close('')
    verdict, _ = verify_bag(path)
    return [(each.topic, each.field) for each in verdict.changed] == [(topic, name)]


def _copied(bag: Path, copy: McapFile) -> Iterator[tuple[str, bytes, int]]:
    """Yield a bag's messages, their topics made known to a copy."""
    with BagReader(bag) as reader:
        for topic, kind, data, time_ns in reader.serialized():
            definition = reader.definition(topic)
            if topic not in copy.counts and definition:
                copy.add(topic, kind, definition, reader.offered(topic))
            yield topic, data, time_ns


def _fields(item: tuple[str, str, bytes, int]) -> list[str]:
    """Return the fields of a cloud that has points."""
    _, kind, data, time_ns = item
    if kind != CLOUD:
        return []
    return [name for name, each in Canonical.of(kind, data, time_ns).fields.items() if each]
