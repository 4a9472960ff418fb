"""What a report is made of: the truth of one bag, the tracks and records of another."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import image_from_message, stamp_ns_of
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.interfaces import Detections, Rows, Ticks, Tracks
from mctrack_ros.recording import BagError, BagReader, frame_origin_ns

AnyRows = TypeVar('AnyRows', bound=Rows)

TRUTH_TOPIC = '/truth/tracks'


@dataclass(frozen=True, eq=False, slots=True)
class Session:
    """
    A tracked recording beside its truth, in the time of the tracks.

    Attributes
    ----------
    source, recorded : Path
        The bag with images and truth, and the bag with what was made of it.
    offset_ns : int
        What the player added to the source's stamps.
    period_ns : int
        Between instants of truth.
    cameras : tuple of str
        Names, in the order of the bits and of `/ticks`.
    truth, tracks : tuple of Tracks
        One for each instant.
    logged_ns : (n,) int64 array
        When each of the tracks was received.
    ticks : tuple of Ticks
        What each tick was made from.
    site : dict
        What `/site` said.

    """

    source: Path
    recorded: Path
    offset_ns: int
    period_ns: int
    cameras: tuple[str, ...]
    truth: tuple[Tracks, ...]
    tracks: tuple[Tracks, ...]
    logged_ns: NDArray[np.int64]
    ticks: tuple[Ticks, ...]
    site: dict[str, Any]

    @property
    def start_ns(self) -> int:
        """Where frame 0 begins: half a period before the first instant of truth."""
        return frame_origin_ns(self.truth[0].stamp_ns, self.period_ns)

    @property
    def duration_s(self) -> float:
        """Length of the truth, s."""
        return round(len(self.truth) * self.period_ns * 1e-9, 6)

    def seconds(self, stamp_ns: int) -> float:
        """Return a stamp in s since the start."""
        return (stamp_ns - self.start_ns) * 1e-9

    def trajectories(self) -> tuple[Trajectories, Trajectories]:
        """Return truth and tracks, in frames of one period from the start."""
        truth = Trajectories.from_tracks(self.truth, self.period_ns, self.start_ns)
        tracks = Trajectories.from_tracks(self.tracks, self.period_ns, self.start_ns)
        inside = (tracks.frame >= 0) & (tracks.frame < len(self.truth))
        return truth, tracks.select(inside)

    def latency_ms(self) -> NDArray[np.float64]:
        """Return from capture to reception of each of the tracks, (n,) ms."""
        stamps = np.array([rows.stamp_ns for rows in self.tracks], np.int64)
        return np.asarray((self.logged_ns - stamps) * 1e-6, np.float64)


def load_session(source: str | Path, recorded: str | Path) -> Session:
    """
    Read both bags.

    Parameters
    ----------
    source : str or Path
        Bag with images and ``/truth/tracks``.
    recorded : str or Path
        Bag with ``/tracks``, ``/ticks``, ``/site`` and ``<camera>/detections``; its stamps may
        differ from the source's by a constant, which its ``/truth/tracks`` shows.

    Raises
    ------
    BagError
        If a bag cannot be read, a topic is missing, or the truth of the two does not fit.

    """
    truth, _ = read_rows(source, TRUTH_TOPIC, Tracks)
    if len(truth) < 2:
        raise BagError(f'{source}: {TRUTH_TOPIC} holds {len(truth)} messages, expected 2 or more')
    with BagReader(recorded) as reader:
        topics = reader.topics
        texts = [m.data for _, m, _ in reader.messages(['/site'])] if '/site' in topics else []
    restamped = read_rows(recorded, TRUTH_TOPIC, Tracks)[0] if TRUTH_TOPIC in topics else truth[:1]
    offset_ns = _offset_ns(truth, restamped, Path(recorded))
    tracks, logged = read_rows(recorded, '/tracks', Tracks)
    site = json.loads(texts[0]) if texts else {}
    seen = [name.split('/')[1] for name in topics if name.endswith('/detections')]
    return Session(
        source=Path(source),
        recorded=Path(recorded),
        offset_ns=offset_ns,
        period_ns=int(np.median(np.diff([rows.stamp_ns for rows in truth]))),
        cameras=tuple(site.get('cameras', sorted(seen))),
        truth=tuple(_shifted(rows, offset_ns) for rows in truth),
        tracks=tuple(tracks),
        logged_ns=np.array(logged, np.int64),
        ticks=tuple(read_rows(recorded, '/ticks', Ticks)[0]),
        site=site,
    )


def read_rows(bag: str | Path, topic: str, kind: type[AnyRows]) -> tuple[list[AnyRows], list[int]]:
    """Return all clouds of a topic in the order of their stamps, and their log times, ns."""
    with BagReader(bag) as reader:
        read = sorted(reader.rows(topic, kind), key=lambda item: item[0].stamp_ns)
    return [rows for rows, _ in read], [time_ns for _, time_ns in read]


def detections_near(session: Session, camera: str, stamp_ns: int) -> Detections | None:
    """Return the camera's recorded detections nearest to a stamp, within a second."""
    topic, second = f'/{camera}/detections', 1_000_000_000
    with BagReader(session.recorded) as reader:
        if topic not in reader.topics:
            return None
        window = reader.rows(topic, Detections, stamp_ns - second, stamp_ns + 2 * second)
        near = [rows for rows, _ in window if abs(rows.stamp_ns - stamp_ns) <= second]
    return min(near, key=lambda rows: abs(rows.stamp_ns - stamp_ns), default=None)


def image_at(session: Session, camera: str, stamp_ns: int) -> NDArray[np.uint8] | None:
    """Return the camera's (height, width, 3) image of exactly a stamp of the recording."""
    topic, wanted = f'/{camera}/image_raw/compressed', stamp_ns - session.offset_ns
    second = 1_000_000_000
    with BagReader(session.source) as reader:
        if topic not in reader.topics:
            return None
        for _, message, _ in reader.messages([topic], wanted - second, wanted + second):
            if stamp_ns_of(message) == wanted:
                return image_from_message(message)
    return None


def _offset_ns(truth: Sequence[Tracks], restamped: Sequence[Tracks], recorded: Path) -> int:
    """Return what was added to the stamps: the recording's first truth is looked up by value."""
    if not restamped:
        raise BagError(f'{recorded}: {TRUTH_TOPIC} holds no messages')
    first = restamped[0]
    for rows in truth:
        if np.array_equal(rows.position, first.position) and len(rows):
            return first.stamp_ns - rows.stamp_ns
    raise BagError(f'{recorded} holds another truth: it was not made from this source')


def _shifted(rows: Tracks, offset_ns: int) -> Tracks:
    columns = {name: getattr(rows, name) for name in rows.COLUMNS}
    return Tracks.build(rows.stamp_ns + offset_ns, **columns)
