"""The benchmark of streams measures what it says, and hostile readers trouble no other."""

import subprocess
import sys
import time
from itertools import count

import numpy as np

from mctrack_experiments.bench.store import RATE_HZ, TRACKS
from mctrack_experiments.bench.streams.hostile_clients import KINDS
from mctrack_experiments.bench.streams.latency import GoodReader
from mctrack_experiments.bench.streams.sizes import measure_sizes
from mctrack_ros.interfaces import Tracks
from mctrack_ros.streams.formats.profiles import all_profiles
from mctrack_ros.streams.frames import About, Assembler
from mctrack_ros.streams.serve.hub import Hub
from mctrack_ros.streams.serve.server import Place, StreamServer

PATIENCE_S = 60.0
HOSTILE_S = 4.0


def tape():
    """Return messages of as many tracks as are measured, whose numbers have many digits."""
    random = np.random.default_rng(1)
    position = random.uniform(0, 100, (TRACKS, 3))
    velocity = random.normal(size=(TRACKS, 2))
    found = []
    for tick in range(50):
        moved = position + np.pad(velocity, ((0, 0), (0, 1))) * tick / RATE_HZ
        roots = random.normal(size=(TRACKS, 4, 4))
        found.append(
            Tracks.build(
                tick,
                position=moved,
                velocity=velocity + random.normal(0, 0.05, velocity.shape),
                covariance=roots @ roots.transpose(0, 2, 1),
                track_id=np.arange(TRACKS) + 1,
                class_id=np.ones(TRACKS),
            )
        )
    return found


def test_every_form_is_measured_on_the_wire():
    figures = measure_sizes(tape())
    assert len(figures) == 2 * len(all_profiles()) + 1
    assert all(5 < size < 60 for size in figures.values()), figures


def test_hostile_readers_trouble_no_other():
    assert sum(clients for _, clients in KINDS) == 200
    hub = Hub(all_profiles(), 60.0, 32)
    with StreamServer(hub, Place(), 32) as server:
        server.start()
        hub.describe(About('bench'))
        reader = GoodReader(server.port)
        command = [sys.executable, '-m', 'mctrack_experiments.bench.streams.hostile_clients']
        clients = subprocess.Popen(
            [*command, str(server.port), str(PATIENCE_S)], stdin=subprocess.PIPE, text=True
        )
        try:
            clients.stdin.write('on\n')
            clients.stdin.flush()
            end = time.monotonic() + PATIENCE_S
            while server.connections < 50:
                assert time.monotonic() < end, 'the clients do not come'
                time.sleep(0.05)
            assembler, until, messages = Assembler(About('bench')), 0.0, tape()
            for tick in count():
                assembler.add_tracks(messages[tick % len(messages)].at(1_000_000_000 + tick))
                hub.publish(assembler.finish())
                time.sleep(1 / RATE_HZ)
                until = until or time.monotonic() + HOSTILE_S
                if time.monotonic() > until:
                    break
            while reader.figures()['reader.frames'] < tick + 1:
                assert time.monotonic() < end, 'the reader lacks frames'
                time.sleep(0.05)
            assert clients.poll() is None
        finally:
            clients.terminate()
            clients.wait()
