"""The stamps of a bag's messages, judged before it is tracked as they are judged live."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.camera_clocks import JUMPED, KEPT, CameraClocks, Jump
from mctrack_ros.fusion.config import BatchingConfig
from mctrack_ros.interfaces import Detections, starts_anew
from mctrack_ros.recording import BagError, BagReader, stated_clock_offsets
from mctrack_ros.replay.quality import LEFT_OUT, SECOND_NS, Stamps
from mctrack_ros.site.site import SiteConfig

_ALIKE = 2.0
"""Largest ratio of the pace of log times to that of stamps at which they are times of arrival."""

_HEADER = 12
"""Bytes up to the end of a header's stamp, the first field of a serialised message."""


class Entry(NamedTuple):
    """One message: its camera, its stamp and its log time, ns."""

    camera: str
    stamp_ns: int
    log_ns: int


def read_entries(reader: BagReader, topics: dict[str, str], log_times: bool) -> list[Entry]:
    """
    Return what is judged by of the messages of some topics, by log time.

    Parameters
    ----------
    reader : BagReader
        The bag.
    topics : dict of str to str
        Camera by topic.
    log_times : bool
        Whether log times stand for the stamps.

    Raises
    ------
    BagError
        If all stamps of a topic are zero, or a message is none with a header.

    """
    entries = []
    for topic, _, data, log_ns in reader.serialized(list(topics)):
        if len(data) < _HEADER:
            raise BagError(f'{reader.path}: a message on {topic} is too short for a header')
        order = '<' if data[1] & 1 else '>'
        seconds, nanoseconds = struct.unpack_from(f'{order}iI', data, 4)
        stamp_ns = log_ns if log_times else seconds * SECOND_NS + nanoseconds
        entries.append(Entry(topics[topic], stamp_ns, log_ns))
    stamped = {entry.camera for entry in entries if entry.stamp_ns}
    for topic, camera in topics.items():
        if camera not in stamped:
            raise BagError(
                f'{reader.path}: all stamps on {topic} are zero: use the times of recording '
                'instead, by --log-times'
            )
    return entries


def corrected(
    entries: Sequence[Entry], reader: BagReader, topics: dict[str, str], site: SiteConfig
) -> list[Entry]:
    """
    Take from stamps what the site says that the cameras' clocks are ahead.

    Detections whose stamps a run has corrected before, as the bag's `/site` says, are corrected by
    the difference.
    """
    stated = stated_clock_offsets(reader)
    ahead_ns = {}
    for topic, camera in topics.items():
        has_been = topic.endswith(f'/{Detections.TOPIC}')
        before_ns = round(stated.get(camera, 0.0) * 1e3) * 1_000_000 if has_been else 0
        ahead_ns[camera] = site.cameras[camera].ahead_ns - before_ns
    return [entry._replace(stamp_ns=entry.stamp_ns - ahead_ns[entry.camera]) for entry in entries]


def judge(
    entries: Sequence[Entry], cameras: Sequence[str], config: BatchingConfig
) -> tuple[dict[str, Stamps], list[Jump]]:
    """
    Judge the stamps of a bag's messages.

    Clocks are compared as the fusion node does it, with the log time for the arrival, where log
    times pass about as fast as stamps do; else all stamps count as right. What the first messages
    tell is known from the start.

    Parameters
    ----------
    entries : sequence of Entry
        By log time.
    cameras : sequence of str
        Names in the site's order.
    config : BatchingConfig
        When clocks agree.

    Returns
    -------
    stamps : dict of str to Stamps
        By camera.
    jumps : list of Jump
        Of all cameras' clocks at once, by log time.

    """
    clocks, sessions = CameraClocks(config, cameras), _Sessions()
    stamps = {camera: Stamps() for camera in cameras}
    are_compared = logged_on_arrival(entries)
    for camera, stamp_ns, log_ns in _beginning(entries) if are_compared else ():
        clocks.judge(camera, stamp_ns, log_ns)
    jumps, known, left_out = [], clocks.jump, list[tuple[int, str]]()
    for camera, stamp_ns, log_ns in entries:
        own, session = stamps[camera], None
        verdict = clocks.judge(camera, stamp_ns, log_ns if are_compared else stamp_ns)
        if verdict.is_used:
            session = sessions.place(camera, stamp_ns + verdict.added_ns)
            own.late += session is None
        else:
            own.left_out += 1
            own.left_out_s.append((verdict.reference_ns - log_ns + stamp_ns) / SECOND_NS)
            left_out.append((log_ns, camera))
        if clocks.has_jumped(camera):
            own.jumped_at.append(len(own.stamp_ns) + 1 - JUMPED)
        if clocks.jump is not None and clocks.jump is not known:
            known = clocks.jump
            jumps.append(known)
            while left_out and left_out[-1][0] >= known.begin_ns:
                stamps[left_out.pop()[1]].left_out_s.pop()
        own.stamp_ns.append(LEFT_OUT if session is None else stamp_ns + verdict.added_ns)
        own.session.append(session or 0)
    for camera, own in stamps.items():
        own.added_s = clocks.added_s(camera)
    return stamps, jumps


def _beginning(entries: Sequence[Entry]) -> list[Entry]:
    """Return the first messages of every camera, from which its clock is judged."""
    counts: dict[str, int] = defaultdict(int)
    first = []
    for entry in entries:
        counts[entry.camera] += 1
        if counts[entry.camera] <= KEPT:
            first.append(entry)
    return first


def logged_on_arrival(entries: Sequence[Entry]) -> bool:
    """Return whether log times advance like stamps; otherwise they are not times of arrival."""
    by_camera: dict[str, list[tuple[int, int]]] = defaultdict(list)
    for camera, stamp_ns, log_ns in entries:
        by_camera[camera].append((stamp_ns, log_ns))
    for times in by_camera.values():
        stamp_s, log_s = _usual_gap(np.array(times, np.int64))
        if not stamp_s / _ALIKE <= log_s <= stamp_s * _ALIKE:
            return False
    return True


def _usual_gap(times: NDArray[np.int64]) -> tuple[float, float]:
    if len(times) < 2:
        return 1.0, 1.0
    gaps = np.median(np.diff(times, axis=0), axis=0) / SECOND_NS
    return float(gaps[0]), float(gaps[1])


class _Sessions:
    """Counts how often time begins anew: a camera's stamps step back by more than a second."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[int, int]] = {}
        self._session = 0
        self._newest_ns = 0

    def place(self, camera: str, stamp_ns: int) -> int | None:
        """Return the session of a camera's next message; None: it comes again or is late."""
        session, last_ns = self._last.get(camera, (self._session, stamp_ns - 1))
        if stamp_ns <= last_ns and not starts_anew(stamp_ns, last_ns):
            return None
        if stamp_ns < last_ns:
            session += 1
        elif session < self._session and abs(stamp_ns - self._newest_ns) < stamp_ns - last_ns:
            session = self._session
        if session > self._session:
            self._session, self._newest_ns = session, stamp_ns
        elif session == self._session:
            self._newest_ns = max(self._newest_ns, stamp_ns)
        self._last[camera] = session, stamp_ns
        return session
