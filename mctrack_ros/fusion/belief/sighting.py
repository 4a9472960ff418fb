"""What a camera tells of one image: detections, and the particles of targets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from mctrack_ros.interfaces import Belief, Detections


@dataclass(frozen=True, eq=False, slots=True)
class BeliefSighting:
    """
    Both, of the same image.

    Attributes
    ----------
    detections : Detections
        By which targets start.
    belief : Belief
        By which they are tracked.

    """

    detections: Detections
    belief: Belief

    @property
    def stamp_ns(self) -> int:
        """Stamp of the image, ns."""
        return self.belief.stamp_ns

    def __len__(self) -> int:
        """Return the number of particles."""
        return len(self.belief)

    def at(self, stamp_ns: int) -> Self:
        """Return the same under another stamp, ns."""
        return type(self)(self.detections.at(stamp_ns), self.belief.at(stamp_ns))
