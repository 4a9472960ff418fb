"""What stands still in a few pictures: their median, kept without a pause for sorting."""

from __future__ import annotations

import cv2

from mctrack_ros.perception.patches import Grey, Motion, median_motion


class RankedPictures:
    """
    Pictures sorted at each pixel, and how they lay.

    Passers-by are darker or brighter than what is behind them, so where they cover a pixel less
    than half of the time its median shows what stands still. One picture is sorted in at a time
    (an insertion, each exchange a minimum and a maximum of whole pictures), so no picture waits
    for all.

    """

    def __init__(self) -> None:
        self._ranked: list[Grey] = []
        self._motions: list[Motion] = []

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._ranked)

    def add(self, grey: Grey, motion: Motion) -> None:
        """Sort a picture in that lies so over the reference."""
        rest = grey
        for rank, ranked in enumerate(self._ranked):
            self._ranked[rank] = cv2.min(ranked, rest)  # type: ignore[assignment]
            rest = cv2.max(ranked, rest)  # type: ignore[assignment]
        self._ranked.append(rest)
        self._motions.append(motion)

    def median(self) -> tuple[Grey, Motion]:
        """Return the median picture and how it lies; there must be a picture."""
        return self._ranked[len(self._ranked) // 2], median_motion(self._motions)

    def clear(self) -> None:
        """Forget the pictures."""
        self._ranked.clear()
        self._motions.clear()
