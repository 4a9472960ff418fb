"""Whether live runs over one bag, at any speed, give the tracks that a replay gives."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from dataclasses import replace
from pathlib import Path

from mctrack_ros.cli.sites import named_site
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import Ticks
from mctrack_ros.recording import BagReader, attachments
from mctrack_ros.recording.track_log.log import EMPTY, StoredLog, chained
from mctrack_ros.replay.proof.verify import verify_bag
from mctrack_ros.ros.graph.graph import ENVIRONMENT, player_node, recorder_node
from mctrack_ros.ros.graph.site_graph import site_nodes
from mctrack_ros.ros.graph.supervise import Supervisor

RATES = (0.5, 1.0, 2.0, 4.0, 1000.0)
_DEPTH = 2000
"""So much may wait: all of the bag, so that the recorder misses nothing at any speed."""
_FUSED = ('camera', 'admitted', 'detections', 'added_ms', 'age_us')
_RECORDED = '/(cam./detections|tracks|ticks|site)'


def bench_live_replay(bag: Path, runs: int = 2) -> Figures:
    """
    Play a bag of detections into a live fusion node at several speeds, and verify each recording.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch.
    runs : int
        At each speed.

    """
    ticks: Counter[bytes] = Counter()
    tracks: dict[bytes, set[bytes]] = {}
    verified = count = 0
    for rate in RATES * runs:
        with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
            recorded = Path(folder) / 'recorded'
            _run(bag, recorded, rate)
            verified += verify_bag(recorded)[0].is_same
            admitted = _admitted(recorded)
            ticks[admitted] += 1
            tracks.setdefault(admitted, set()).add(_tracks(recorded))
            count += 1
    figures = {
        'runs': count,
        'verified': verified,
        'other_hashes': sum(len(each) - 1 for each in tracks.values()),
        'same_ticks_share': ticks.most_common(1)[0][1] / count,
    }
    protocol = {
        'bag': bag.name,
        'rates': ', '.join(f'{rate:g}' for rate in RATES),
        'other_hashes': 'runs that fused the same by /ticks and whose tracks are not the same',
        'same_ticks_share': 'runs that fused what most did',
        'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
    }
    return Figures('bench_live_replay', 'mctrack bench live-replay', protocol, figures)


def _run(bag: Path, recorded: Path, rate: float) -> None:
    """Play a bag at a speed into a fusion node, and record what it was given and made of it."""
    fusion, *_ = site_nodes(named_site('pitch5'), use_sim_time=True, own_detections=True)
    nodes = [
        replace(fusion, parameters={**fusion.parameters, 'state_file': ''}),
        recorder_node(recorded, [_RECORDED], depth=_DEPTH),
        player_node(
            bag,
            topics=['/cam./detections'],
            rate=rate,
            wait_for=['/cam./detections 2'],
            wait=120.0,
            depth=_DEPTH,
        ),
    ]
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        supervisor = Supervisor([n.process(Path(folder)) for n in nodes], print, ENVIRONMENT)
        if supervisor.run():
            raise RuntimeError('; '.join(supervisor.failures))


def _admitted(bag: Path) -> bytes:
    """Return the hash of what `/ticks` says was fused; not of what was late or missing."""
    digest = EMPTY
    with BagReader(bag) as reader:
        for rows, _ in reader.rows('/ticks', Ticks):
            fields = {name: getattr(rows, name).tobytes() for name in _FUSED}
            digest = chained(digest, rows.stamp_ns, fields)
    return digest


def _tracks(bag: Path) -> bytes:
    """Return the hash of the tracks that a bag states."""
    return StoredLog.of(attachments(bag)).hashes['/tracks'][1]
