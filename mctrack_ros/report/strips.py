"""One merge and one split, image by image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections, EventCode, Events
from mctrack_ros.perception.overlay import Overlay
from mctrack_ros.recording import BagReader
from mctrack_ros.report.images import data_address
from mctrack_ros.report.session import Session, image_at, read_rows

Image = NDArray[np.uint8]

OFFSETS_S = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6)
"""Of a strip's images from the event, s."""

LONGEST_S = 10.0
"""The two meet for no longer, s."""

_HEIGHT_PX = 240
_MARGIN = 0.35


@dataclass(frozen=True, slots=True)
class Encounter:
    """
    Two people who become a group and part again, from a camera's events.

    Attributes
    ----------
    camera : str
        Its name.
    pair : (int, int)
        Local ids.
    merged_ns, split_ns : int
        When.

    """

    camera: str
    pair: tuple[int, int]
    merged_ns: int
    split_ns: int


@dataclass(frozen=True, slots=True)
class Frame:
    """One image of a strip: what stands below it, and itself as a ``data:`` address."""

    caption: str
    jpeg: str


@dataclass(frozen=True, slots=True)
class Strip:
    """Images of one event in the order of time, with the camera's name and a title."""

    camera: str
    title: str
    frames: tuple[Frame, ...]


def encounter_strips(session: Session) -> list[Strip]:
    """Return the strips of the merge and the split of the pair that is largest in an image."""
    found: list[tuple[float, Encounter, dict[int, Detections]]] = []
    with BagReader(session.recorded) as reader:
        topics = reader.topics
    for camera in session.cameras:
        if {f'/{camera}/events', f'/{camera}/detections'} - set(topics):
            continue
        events = read_rows(session.recorded, f'/{camera}/events', Events)[0]
        detections = read_rows(session.recorded, f'/{camera}/detections', Detections)[0]
        by_stamp = {rows.stamp_ns: rows for rows in detections}
        found += [(_size(one, by_stamp), one, by_stamp) for one in encounters(camera, events)]
    size, encounter, by_stamp = max(found, key=lambda item: item[0], default=(0.0, None, {}))
    if encounter is None or size == 0.0:
        return []
    moments = {'merge': encounter.merged_ns, 'split': encounter.split_ns}
    strips = [_strip(session, encounter, by_stamp, *moment) for moment in moments.items()]
    return [strip for strip in strips if strip.frames]


def encounters(camera: str, events: list[Events]) -> Iterator[Encounter]:
    """Yield each merge of exactly two with the next split of the same two."""
    merged: dict[frozenset[int], int] = {}
    for rows in events:
        for row in np.flatnonzero(rows.local_id > 0).tolist():
            others = rows.others[row][rows.others[row] > 0].tolist()
            pair = frozenset([int(rows.local_id[row]), *others])
            if len(pair) != 2:
                continue
            if rows.event[row] == EventCode.MERGE:
                merged[pair] = rows.stamp_ns
            elif rows.event[row] == EventCode.SPLIT and pair in merged:
                first, second = sorted(pair)
                yield Encounter(camera, (first, second), merged.pop(pair), rows.stamp_ns)


def _size(encounter: Encounter, by_stamp: Mapping[int, Detections]) -> float:
    """Return how high, px, the smaller of the two is; 0: not to be shown."""
    lasted = (encounter.split_ns - encounter.merged_ns) * 1e-9
    sizes = []
    for when_ns in (encounter.merged_ns, encounter.split_ns):
        rows = by_stamp.get(when_ns)
        box = np.zeros((0, 4)) if rows is None else rows.box[_of(rows, encounter.pair)]
        sizes.append(float(box[:, 3].min()) if len(box) == 2 else 0.0)
    return min(sizes) if 2 * OFFSETS_S[-1] < lasted < LONGEST_S else 0.0


def _strip(
    session: Session,
    encounter: Encounter,
    by_stamp: Mapping[int, Detections],
    title: str,
    when_ns: int,
) -> Strip:
    stamps = np.array(sorted(by_stamp), np.int64)
    wanted = when_ns + np.round(np.array(OFFSETS_S) * 1e9).astype(np.int64)
    shown = np.unique(stamps[np.abs(stamps[:, None] - wanted).argmin(axis=0)]).tolist()
    window = _window([by_stamp[stamp_ns] for stamp_ns in shown], encounter.pair)
    frames = []
    for stamp_ns in shown:
        image = image_at(session, encounter.camera, stamp_ns)
        if image is None:
            continue
        grouped = encounter.merged_ns <= stamp_ns < encounter.split_ns
        groups = [encounter.pair] if grouped else []
        drawn = Overlay().draw(image, by_stamp[stamp_ns], Events.build(stamp_ns), groups)
        label = title if stamp_ns == when_ns else f'{(stamp_ns - when_ns) * 1e-9:+.2f} s'
        caption = f'{session.seconds(stamp_ns):.2f} s: {label}'
        frames.append(Frame(caption, data_address(_cut(drawn, window))))
    return Strip(encounter.camera, title, tuple(frames))


def _window(rows: list[Detections], pair: tuple[int, int]) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom, px, of what surrounds two people all the time."""
    box = np.concatenate([each.box[_of(each, pair)] for each in rows])
    low, high = box[:, :2].min(axis=0), (box[:, :2] + box[:, 2:]).max(axis=0)
    margin = _MARGIN * (high - low).max()
    return (*(low - margin).tolist(), *(high + margin).tolist())


def _cut(image: Image, window: tuple[float, float, float, float]) -> Image:
    """Return the part of an image in a window, in one height."""
    left, top = (max(round(value), 0) for value in window[:2])
    right, bottom = round(window[2]), round(window[3])
    part = image[top:bottom, left:right]
    width = max(round(part.shape[1] * _HEIGHT_PX / part.shape[0]), 1)
    resized = cv2.resize(part, (width, _HEIGHT_PX), interpolation=cv2.INTER_CUBIC)
    return np.asarray(resized, np.uint8)


def _of(rows: Detections, pair: tuple[int, int]) -> NDArray[np.bool_]:
    return np.isin(rows.local_id, pair)
