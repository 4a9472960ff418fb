"""What the codec makes of malformed messages: rows, an image, or a refusal; nothing else."""

from __future__ import annotations

import gc
import os
import resource
import struct
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mctrack_experiments.bench.fuzz.clouds import malformed_cloud, octets_of
from mctrack_experiments.bench.fuzz.images import (
    HEIGHT,
    WIDTH,
    malformed_compressed,
    malformed_raw,
)
from mctrack_experiments.bench.workers import Progress, run_pinned, silent
from mctrack_ros.codec import CodecError, image_from_message, message_from_ros, rows_from_cloud
from mctrack_ros.codec.image_header import stated_size
from mctrack_ros.interfaces import Foreground, Rows
from mctrack_ros.recording import ROSBAGS_CLASSES

CHUNK = 5000
"""Messages of one seed."""

LONGEST_REASON = 1000
"""Characters of a refusal."""

MEMORY_BYTES = 4 * 2**30
_FORMATS = {1: 'b', 2: 'B', 3: 'h', 4: 'H', 5: 'i', 6: 'I', 7: 'f', 8: 'd'}


@dataclass(slots=True)
class Outcome:
    """
    What became of malformed messages.

    Attributes
    ----------
    refused, taken : Counter
        Messages by kind: ``cloud``, ``raw``, ``compressed``, ``mask``.
    faults : list of str
        What should not have happened: another exception than a refusal, a wrong result.
    worst_ms : float
        Longest processor time of a message, ms.
    lines : int
        What was written to standard error below Python.
    memory_mb : float
        Largest memory of the process so far, MB.

    """

    refused: Counter[str] = field(default_factory=Counter)
    taken: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    worst_ms: float = 0.0
    lines: int = 0
    memory_mb: float = 0.0


def fuzz_codec(messages: int, progress: Progress = silent) -> tuple[dict[str, float], str]:
    """
    Decode malformed messages in a process of their own, half of them clouds, half images.

    Raises
    ------
    concurrent.futures.process.BrokenProcessPool
        If the process crashed.

    """
    seeds = range(-(-messages // CHUNK))
    outcomes = run_pinned(_limited, seeds, progress)
    refused, taken = Counter[str](), Counter[str]()
    for each in outcomes:
        refused.update(each.refused)
        taken.update(each.taken)
    figures: dict[str, Any] = {
        'codec.messages': refused.total() + taken.total(),
        'codec.refused': refused.total(),
        'codec.faults': sum(len(each.faults) for each in outcomes),
        'codec.worst_ms': max(each.worst_ms for each in outcomes),
        'codec.lines': sum(each.lines for each in outcomes),
        'codec.growth_mb': outcomes[-1].memory_mb - outcomes[0].memory_mb,
    }
    for kind in sorted(refused | taken):
        figures[f'codec.{kind}.refused'] = refused[kind]
        figures[f'codec.{kind}.taken'] = taken[kind]
    faults = [fault for each in outcomes for fault in each.faults]
    return figures, '; '.join(faults[:5])


def _limited(seed: int) -> Outcome:
    """Decode within limited memory."""
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, hard))
    return fuzzed(seed)


def fuzzed(seed: int, count: int = CHUNK) -> Outcome:
    """Decode the malformed messages of one seed."""
    outcome, rng = Outcome(), np.random.default_rng([seed, 7])
    gc.collect()
    gc.freeze()  # what was there before is left alone, as in a node's process
    with _lines_counted(outcome):
        for number in range(count):
            one = _CASES[int(rng.choice(len(_CASES), p=_SHARES))]
            try:
                one(outcome, rng)
            except Exception as error:  # whatever is not a refusal
                outcome.faults.append(f'seed {seed}, message {number}: {error!r}')
    outcome.memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return outcome


@contextmanager
def _lines_counted(outcome: Outcome) -> Iterator[None]:
    """Count what libraries write to standard error meanwhile."""
    kept = os.dup(2)
    with tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            said.seek(0)
            outcome.lines = len(said.readlines())


def _decoded(outcome: Outcome, kind: str, read: Any) -> Any:
    """Decode within measured time; return what came out, None: it was refused."""
    began_s = time.thread_time()
    try:
        made = read()
    except CodecError as error:
        reason = str(error)
        if '\n' in reason or len(reason) > LONGEST_REASON:
            raise AssertionError(f'a refusal of {len(reason)} characters') from error
        outcome.refused[kind] += 1
        return None
    finally:
        outcome.worst_ms = max(outcome.worst_ms, (time.thread_time() - began_s) * 1e3)
    outcome.taken[kind] += 1
    return made


def _cloud(outcome: Outcome, rng: np.random.Generator) -> None:
    message, kind = malformed_cloud(ROSBAGS_CLASSES, rng)
    rows = _decoded(outcome, 'cloud', lambda: rows_from_cloud(message, kind))
    if rows is not None:
        _check_rows(message, rows)


def _check_rows(message: Any, rows: Rows) -> None:
    """Read each field of the last row by the message's own description, byte by byte."""
    count = message.height * message.width
    assert len(rows) == count, f'{len(rows)} rows of {count}'
    if not count:
        return
    data = octets_of(message).tobytes()
    for described in message.fields:
        start = (count - 1) * message.point_step + described.offset
        form = f'<{described.count}{_FORMATS.get(described.datatype, "B")}'
        if described.name in ('x', 'y', 'z'):
            found = rows.position[-1]['xyz'.index(described.name)]
        elif described.name in rows.COLUMNS and described.name != 'position':
            found = getattr(rows, described.name)[-1]
            if found.ndim == 2:
                found = found[np.triu_indices(len(found))]
        else:
            continue
        expected = struct.unpack_from(form, data, start)
        same = np.array_equal(np.ravel(found), expected, equal_nan=found.dtype.kind == 'f')
        assert same, f'{described.name} is {found!r}, expected {expected!r}'
    assert all(np.isfinite(rows.position).ravel()) or not message.is_dense


def _size(rng: np.random.Generator) -> tuple[int, int] | None:
    return (WIDTH, HEIGHT) if rng.random() < 0.5 else None


def _raw(outcome: Outcome, rng: np.random.Generator) -> None:
    message, size = malformed_raw(ROSBAGS_CLASSES, rng), _size(rng)
    image = _decoded(outcome, 'raw', lambda: image_from_message(message, size))
    if image is not None:
        _check_image(image, (message.width, message.height), size)


def _compressed(outcome: Outcome, rng: np.random.Generator) -> None:
    (message, is_cut), size = malformed_compressed(ROSBAGS_CLASSES, rng), _size(rng)
    image = _decoded(outcome, 'compressed', lambda: image_from_message(message, size))
    if image is not None:
        _check_image(image, stated_size(memoryview(message.data)), size)
        assert not is_cut, 'a cut-off image was taken'


def _mask(outcome: Outcome, rng: np.random.Generator) -> None:
    message, is_cut = malformed_compressed(ROSBAGS_CLASSES, rng)
    made = _decoded(outcome, 'mask', lambda: message_from_ros(message, Foreground))
    if made is not None and made.mask.size:
        assert set(np.unique(made.mask)) <= {0, 255}
        assert not is_cut, 'a cut-off mask was taken'


def _check_image(image: Any, stated: Any, size: tuple[int, int] | None) -> None:
    assert image.dtype == np.uint8
    assert image.flags.c_contiguous
    assert image.shape == (stated[1], stated[0], 3), f'{image.shape}, stated {stated}'
    assert size is None or stated == size


_CASES = (_cloud, _raw, _compressed, _mask)
_SHARES = (0.5, 0.15, 0.25, 0.1)
