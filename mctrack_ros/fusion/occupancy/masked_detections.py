"""What a camera tells of one image: its mask, and its own detections."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from mctrack_ros.interfaces import Detections, Foreground


@dataclass(frozen=True, eq=False, slots=True)
class MaskedDetections:
    """
    Both, of the same image.

    Attributes
    ----------
    detections : Detections
        Colours and sizes.
    foreground : Foreground
        By which people are found.

    """

    detections: Detections
    foreground: Foreground

    @property
    def stamp_ns(self) -> int:
        """Stamp of the image, ns."""
        return self.detections.stamp_ns

    def __len__(self) -> int:
        """Return the number of detections."""
        return len(self.detections)

    def at(self, stamp_ns: int) -> Self:
        """Return the same under another stamp, ns."""
        return type(self)(self.detections.at(stamp_ns), self.foreground.at(stamp_ns))
