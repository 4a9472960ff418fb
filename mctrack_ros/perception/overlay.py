"""An image of what a camera sees: boxes, ids, groups, predictions, and what happened."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections, EventCode, Events
from mctrack_ros.tracking.colours import track_colour

Image = NDArray[np.uint8]
Colour = tuple[int, int, int]

UNKNOWN = (190, 190, 190)
GROUP = (60, 160, 255)
PREDICTED = (255, 200, 0)
SHOWN_EVENTS = (EventCode.NEW, EventCode.ENTER, EventCode.SPLIT, EventCode.EXIT, EventCode.MERGE)
LINES = 8  # of events that are shown at a time
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_MARGIN_PX = 4
_LINE_PX = 16


class Overlay:
    """
    Draws what a camera sees over its images, and for a while what happened.

    A box has the colour of its global track, the same in every camera, and its id; grey with
    the local id in brackets: the fusion node's is not known; grey with a minus and an id: the
    fusion node expects that one there, and nothing is seen. Orange frames hold groups, thin blue
    boxes are predictions, lines of text are events.

    Parameters
    ----------
    memory_s : float
        How long an event stays in the image, s.

    """

    def __init__(self, memory_s: float = 1.0) -> None:
        self._memory_ns = round(memory_s * 1e9)
        self._lines: deque[tuple[int, str]] = deque(maxlen=LINES)

    def draw(
        self,
        image: Image,
        detections: Detections,
        events: Events,
        groups: Sequence[Sequence[int]] = (),
        predicted: NDArray[np.floating] | None = None,
    ) -> Image:
        """
        Return a drawing over a copy of an image.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image, BGR.
        detections : Detections
            What is seen in it.
        events : Events
            What happened in it.
        groups : sequence of sequences of int
            Local ids that are a group.
        predicted : (n, 4) array, optional
            Predicted boxes of the camera's own tracks: left, top, width, height, px.

        """
        canvas = image.copy()
        for box in np.zeros((0, 4)) if predicted is None else predicted:
            if np.isfinite(box).all():
                _rectangle(canvas, box, PREDICTED)
        for row in range(len(detections)):
            _draw_detection(canvas, detections, row)
        for group in groups:
            _draw_group(canvas, detections.box[np.isin(detections.local_id, group)])
        self._note(events, detections.stamp_ns)
        for number, (_, line) in enumerate(self._lines):
            _write(canvas, line, (6, 14 + number * _LINE_PX), (255, 255, 255))
        return canvas

    def _note(self, events: Events, stamp_ns: int) -> None:
        """Take up what happened; forget what is long past."""
        self._lines.extend(
            (stamp_ns, _sentence(events, row))
            for row in np.flatnonzero(np.isin(events.event, SHOWN_EVENTS)).tolist()
        )
        while self._lines and not 0 <= stamp_ns - self._lines[0][0] < self._memory_ns:
            self._lines.popleft()


def _draw_detection(canvas: Image, detections: Detections, row: int) -> None:
    count, track_id = int(detections.member_count[row]), int(detections.track_id[row])
    members = [int(one) for one in detections.members[row] if one]
    first = track_id or next(iter(members), 0)
    red, green, blue = track_colour(first)
    colour = (blue, green, red) if first else UNKNOWN
    box = detections.box[row]
    _rectangle(canvas, box, colour)
    if count == 1:
        label = str(track_id or f'({detections.local_id[row]})')
    else:
        _draw_group(canvas, box[None])
        label = '+'.join(map(str, members)) or f'{count or "?"} people'
    _write(canvas, label, (int(box[0]), max(int(box[1]) - 4, 10)), colour)


def _draw_group(canvas: Image, boxes: NDArray[np.floating]) -> None:
    """Draw a frame around boxes (n, 4)."""
    if len(boxes):
        low = boxes[:, :2].min(axis=0) - _MARGIN_PX
        high = (boxes[:, :2] + boxes[:, 2:]).max(axis=0) + _MARGIN_PX
        _rectangle(canvas, np.concatenate([low, high - low]), GROUP)


def _sentence(events: Events, row: int) -> str:
    """Return for example ``split 12 from 7 (31)``."""
    code = EventCode(int(events.event[row]))
    link = {EventCode.MERGE: ' with ', EventCode.SPLIT: ' from '}.get(code, ' ')
    pairs = zip(events.others[row], events.other_tracks[row])
    others = ' '.join(_name(local, track) for local, track in pairs if local or track)
    name = _name(events.local_id[row], events.track_id[row])
    return f'{code.name.lower()} {name}' + (link + others if others else '')


def _name(local_id: np.uint32, track_id: np.uint32) -> str:
    """Return a global id, or in brackets the camera's own."""
    return str(track_id) if track_id else f'({local_id})'


def _write(canvas: Image, text: str, place: tuple[int, int], colour: Colour) -> None:
    """Write on a dark outline, readable on any ground."""
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):  # as thick letters they would be wider
        shifted = place[0] + dx, place[1] + dy
        cv2.putText(canvas, text, shifted, _FONT, 0.42, (20, 20, 20), 1, cv2.LINE_AA)
    cv2.putText(canvas, text, place, _FONT, 0.42, colour, 1, cv2.LINE_AA)


def _rectangle(canvas: Image, box: NDArray[np.floating], colour: Colour) -> None:
    left, top, width, height = np.rint(box).astype(int).tolist()
    cv2.rectangle(canvas, (left, top), (left + width - 1, top + height - 1), colour, 1)
