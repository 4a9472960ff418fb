"""
Whether two versions of the code make the same bytes of the golden recordings.

``python -m mctrack_experiments.same`` tracks every recording below ``bags`` with every site
below ``bags/sites/<recording>``, by this version and by another, each by its own command line,
and compares the rows on every topic.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

CLOUD = 'sensor_msgs/msg/PointCloud2'
_WIDTH_OF = {1: 'i1', 2: 'u1', 3: 'i2', 4: 'u2', 5: 'i4', 6: 'u4', 7: 'f4', 8: 'f8'}

Rows = NDArray[np.void]
Message = tuple[int, Rows]


def main() -> int:
    """Compare; the exit status is 1 where something differs."""
    parser = argparse.ArgumentParser(prog='make same', description=__doc__)
    parser.add_argument(
        '--with',
        dest='other',
        default='HEAD' if _git('status', '--porcelain', '--untracked-files=no') else 'HEAD~1',
        help='commit; unless given, that which the working tree, or the last commit, changes',
    )
    parser.add_argument('--json', type=Path, help='also write the hashes of this version here')
    arguments = parser.parse_args()
    here = Path.cwd()
    with tempfile.TemporaryDirectory(prefix='mctrack_same_') as name:
        scratch = Path(name)
        tree = scratch / 'tree'
        commit = _git('rev-parse', '--short', arguments.other)
        _git('worktree', 'add', '--quiet', '--detach', str(tree), commit)
        try:
            differences, hashes = _compared(tree, here, scratch)
        finally:
            _git('worktree', 'remove', '--force', str(tree))
    for line in differences:
        print(line)
    print(f'{len(hashes)} topics, {len(differences)} differ from {commit}')
    if arguments.json:
        arguments.json.write_text(json.dumps(hashes, indent=1) + '\n')
    return bool(differences)


def _compared(other: Path, here: Path, scratch: Path) -> tuple[list[str], dict[str, str]]:
    """Return what differs, a line each, and the hash of each topic of this version."""
    differences: list[str] = []
    hashes: dict[str, str] = {}
    for site in sorted((here / 'bags/sites').rglob('*.yaml')):
        case = str(site.relative_to(here / 'bags/sites').with_suffix(''))
        print(f'{case} ...', file=sys.stderr, flush=True)
        bag = here / 'bags' / Path(case).parent
        after = _tracked(here, bag, case, scratch / 'after' / case)
        hashes |= {f'{case} {topic}': digest(after[topic]) for topic in sorted(after)}
        if not (other / 'bags/sites' / f'{case}.yaml').exists():
            print(f'{case} is new: nothing to compare it with', file=sys.stderr)
            continue
        before = _tracked(other, bag, case, scratch / 'before' / case)
        for topic in sorted(before | after):
            found = first_difference(before.get(topic, []), after.get(topic, []))
            if found:
                differences.append(f'{case} {topic}: {found}')
    return differences, hashes


def _tracked(tree: Path, bag: Path, case: str, out: Path) -> dict[str, list[Message]]:
    """Return what the command line of a version makes of a recording and a site, by topic."""
    site = tree / 'bags/sites' / f'{case}.yaml'
    command = ['track', str(bag), '--site', str(site), '--out', str(out)]
    done = subprocess.run(
        [sys.executable, '-m', 'mctrack_ros.cli.main', *command],
        cwd=tree,
        env={**os.environ, 'PYTHONPATH': f'{tree}{os.pathsep}{tree / "experiments"}'},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f'{case} by {tree}: {done.stderr.strip()}')
    return recorded_rows(out / 'bag')


def recorded_rows(bag: Path) -> dict[str, list[Message]]:
    """Return the stamp, ns, and the rows of each message of the clouds in a bag, by topic."""
    with AnyReader([bag]) as reader:
        clouds = [each for each in reader.connections if each.msgtype == CLOUD]
        found: dict[str, list[Message]] = {each.topic: [] for each in clouds}
        for connection, _, data in reader.messages(connections=clouds):
            message: Any = reader.deserialize(data, connection.msgtype)
            stamp = message.header.stamp
            found[connection.topic].append((stamp.sec * 10**9 + stamp.nanosec, _rows(message)))
    return found


def _rows(message: Any) -> Rows:
    """Return the rows of a cloud, one structured value each."""
    kind = np.dtype(
        {
            'names': [field.name for field in message.fields],
            'formats': [(_WIDTH_OF[field.datatype], (field.count,)) for field in message.fields],
            'offsets': [field.offset for field in message.fields],
            'itemsize': message.point_step,
        }
    )
    return np.frombuffer(bytes(message.data), kind)


def digest(messages: list[Message]) -> str:
    """Return the SHA-256 over stamps and rows."""
    total = hashlib.sha256()
    for stamp_ns, rows in messages:
        total.update(stamp_ns.to_bytes(8, 'little'))
        total.update(rows.tobytes())
    return total.hexdigest()


def first_difference(before: list[Message], after: list[Message]) -> str:
    """Return where two topics differ first; empty: nowhere."""
    for index, ((was_ns, was), (is_ns, now)) in enumerate(zip(before, after)):
        place = f'message {index} at {was_ns * 1e-9:.3f} s'
        if was_ns != is_ns:
            return f'{place}: now at {is_ns * 1e-9:.3f} s'
        if was.dtype.names != now.dtype.names:
            return f'{place}: fields {was.dtype.names}, now {now.dtype.names}'
        if len(was) != len(now):
            return f'{place}: {len(was)} rows, now {len(now)}'
        if was.tobytes() != now.tobytes():
            return f'{place}: {_first_value(was, now)}'
    if len(before) != len(after):
        return f'{len(before)} messages, now {len(after)}'
    return ''


def _first_value(before: Rows, after: Rows) -> str:
    """Return the first value of two clouds, of equal size, that differs."""
    for number, (was, now) in enumerate(zip(before, after)):
        for name in before.dtype.names or ():
            if was[name].tobytes() != now[name].tobytes():
                return f'row {number}, {name} {was[name].tolist()}, now {now[name].tolist()}'
    return 'bytes between the fields'


def _git(*arguments: str) -> str:
    return subprocess.run(
        ['git', *arguments], check=True, capture_output=True, text=True
    ).stdout.strip()


if __name__ == '__main__':
    sys.exit(main())
