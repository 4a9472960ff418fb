"""What a camera tells of one image: colours of targets, likelihoods, and its mask."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from mctrack_ros.interfaces import Detections, Foreground, Likelihood


@dataclass(frozen=True, eq=False, slots=True)
class GridSighting:
    """
    All of it, of the same image.

    Attributes
    ----------
    detections : Detections
        The targets of feedback, by which people are told apart.
    likelihood : Likelihood
        By edges.
    foreground : Foreground
        Unknown, where the camera is to tell edges alone.

    """

    detections: Detections
    likelihood: Likelihood
    foreground: Foreground

    @property
    def stamp_ns(self) -> int:
        """Stamp of the image, ns."""
        return self.likelihood.stamp_ns

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.likelihood)

    def at(self, stamp_ns: int) -> Self:
        """Return the same under another stamp, ns."""
        return type(self)(
            self.detections.at(stamp_ns),
            self.likelihood.at(stamp_ns),
            self.foreground.at(stamp_ns),
        )
