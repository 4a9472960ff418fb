"""The time of a camera's images: how long since the last, and whether it has jumped."""

from __future__ import annotations

from mctrack_ros.interfaces import PAUSE_NS, starts_anew

USUAL_GAPS = 2.5
"""A gap that is no longer than this many of the gap before is the camera's pace, however slow."""


class BackwardStampError(ValueError):
    """An image that is not later than the one before; drop it and go on."""


class ImageClock:
    """
    Follows the stamps of one camera's images.

    Attributes
    ----------
    seconds : float
        From the image before to the last, s; 0 at the first, and where time has jumped.
    jumped : bool
        Whether it came more than a second after the image before, though the camera is not as
        slow as that, or more than a second before it.
    stepped_back : bool
        Whether time has begun anew since: it, or one passed over, came before the one before.

    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.jumped = self.stepped_back = False
        self._last_ns: int | None = None
        self._seen_ns: int | None = None
        self._has_begun_anew = False
        self._gap_ns = 0

    def pass_over(self, stamp_ns: int) -> None:
        """
        Take the stamp, ns, of an image that is not used.

        Raises
        ------
        BackwardStampError
            If it is at or up to a second before the last one; nothing is changed.

        """
        seen = self._seen_ns
        if seen is not None and stamp_ns <= seen and not starts_anew(stamp_ns, seen):
            raise BackwardStampError(
                f'stamp {stamp_ns} is not later than the last, {seen}: the image is not used'
            )
        self._has_begun_anew |= seen is not None and stamp_ns < seen
        self._seen_ns = stamp_ns

    def advance(self, stamp_ns: int) -> None:
        """Take the stamp, ns, of the next image; raise as `pass_over` does."""
        self.pass_over(stamp_ns)
        last, usual_ns = self._last_ns, self._gap_ns
        gap_ns = 0 if last is None else stamp_ns - last
        self.stepped_back, self._has_begun_anew = self._has_begun_anew, False
        self.jumped = self.stepped_back or gap_ns > max(PAUSE_NS, USUAL_GAPS * usual_ns)
        self.seconds = 0.0 if self.jumped else gap_ns * 1e-9
        self._last_ns, self._gap_ns = stamp_ns, max(gap_ns, 0)
