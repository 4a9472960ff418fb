"""A camera device or a network stream: the newest image, whatever goes wrong."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.recording.closing import Closing

Image = NDArray[np.uint8]

_PAUSES_S = (0.5, 30.0)
"""First and longest pause before a source is opened again; each is twice the one before."""
_PATIENCE_MS = 5000
"""For a stream that is opened, or whose next image is read."""
_LOOK_S = 0.2


@dataclass(slots=True)
class LiveCounts:
    """
    What has come of a live source so far.

    Attributes
    ----------
    images, dropped : int
        Images that came, and those of them that a newer one displaced before they were taken.
    opened : int
        How often it was opened.
    failure : str
        Why it gives nothing now; empty: it does.

    """

    images: int = 0
    dropped: int = 0
    opened: int = 0
    failure: str = ''


@dataclass(slots=True)
class _Slot:
    """The newest image."""

    image: Image | None = None
    stamp_ns: int = 0
    changed: threading.Condition = field(default_factory=threading.Condition)


class LiveVideo(Closing):
    """
    Read a device or stream on a thread of its own; the newest image wins.

    Whoever iterates gets the newest image each time; those that came while he was busy are dropped
    and counted, so that he is never behind. A source that cannot be opened or falls silent is
    opened again after a pause that doubles up to half a minute.

    Parameters
    ----------
    address : str or int
        Path or number of a device, or the address of a stream, which may hold a password.
    name : str
        What users are shown in its place.
    now_ns : callable
        Returns the stamp of an image that has just come, ns.
    tell : callable
        Called with a line when the source fails and when it is back; on the reading thread.

    Attributes
    ----------
    counts : LiveCounts
        What has come.

    """

    def __init__(
        self,
        address: str | int,
        name: str,
        now_ns: Callable[[], int],
        tell: Callable[[str], None],
    ) -> None:
        self._address, self._name, self._now_ns, self._tell = address, name, now_ns, tell
        self.counts = LiveCounts()
        self._slot = _Slot()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._read, name='live video', daemon=True)
        self._thread.start()

    def __iter__(self) -> Iterator[tuple[int, Image]]:
        """Yield stamp (ns) and (height, width, 3) image, blue, green, red, until it is closed."""
        while not self._ending.is_set():
            with self._slot.changed:
                if self._slot.image is None:
                    self._slot.changed.wait(_LOOK_S)
                    continue
                image, self._slot.image = self._slot.image, None
                stamp_ns = self._slot.stamp_ns
            yield stamp_ns, image

    def close(self) -> None:
        """End; a stream that is just being opened ends by itself."""
        self._ending.set()
        self._thread.join(_LOOK_S)

    def _read(self) -> None:
        pause_s, longest_s = _PAUSES_S
        while not self._ending.is_set():
            capture = self._opened()
            if capture.isOpened() and self._drain(capture):
                pause_s = _PAUSES_S[0]
            is_open = capture.isOpened()
            capture.release()
            if self._ending.is_set():
                return
            reason = 'fell silent' if is_open else 'cannot be opened as a video'
            self.counts.failure = f'{self._name} {reason}'
            self._tell(f'source {self._name} {reason}: opening it again in {pause_s:g} s')
            self._ending.wait(pause_s)
            pause_s = min(2 * pause_s, longest_s)

    def _opened(self) -> cv2.VideoCapture:
        if isinstance(self._address, int) or '://' not in self._address:
            return cv2.VideoCapture(self._address)
        limits = (cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, cv2.CAP_PROP_READ_TIMEOUT_MSEC)
        parameters = [value for limit in limits for value in (limit, _PATIENCE_MS)]
        return cv2.VideoCapture(self._address, cv2.CAP_FFMPEG, parameters)

    def _drain(self, capture: cv2.VideoCapture) -> bool:
        """Take images until there are no more; return whether there were any."""
        slot, counts = self._slot, self.counts
        has_any = False
        while not self._ending.is_set():
            read, image = capture.read()
            if not read:
                break
            stamp_ns = self._now_ns()
            if not has_any:
                has_any, counts.failure = True, ''
                counts.opened += 1
                if counts.opened > 1:
                    self._tell(f'source {self._name} is back')
            with slot.changed:
                counts.images += 1
                counts.dropped += slot.image is not None
                slot.image, slot.stamp_ns = np.asarray(image, np.uint8), stamp_ns
                slot.changed.notify()
        return has_any
