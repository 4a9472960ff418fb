"""What trackers take from a camera for one image: several messages as one."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

from mctrack_ros.interfaces import Belief, Detections, Foreground, Likelihood


@dataclass(frozen=True, eq=False)
class JoinedMessages:
    """
    Messages of the same image, a field each.

    Attributes
    ----------
    COUNTED : str
        Field whose rows are counted, and whose stamp is that of all.

    """

    __slots__ = ()
    COUNTED: ClassVar[str]

    @property
    def stamp_ns(self) -> int:
        """Stamp of the image, ns."""
        return int(self._counted().stamp_ns)

    def __len__(self) -> int:
        """Return the number of rows of the counted message."""
        return len(self._counted())

    def at(self, stamp_ns: int) -> Self:
        """Return the same under another stamp, ns."""
        every = {each.name: getattr(self, each.name).at(stamp_ns) for each in fields(self)}
        return replace(self, **every)

    def _counted(self) -> Any:
        return getattr(self, self.COUNTED)


@dataclass(frozen=True, eq=False, slots=True)
class OccupancyInput(JoinedMessages):
    """
    Input of tracker `occupancy`.

    Attributes
    ----------
    detections : Detections
        Colours and sizes.
    foreground : Foreground
        By which people are found.

    """

    COUNTED = 'detections'
    detections: Detections
    foreground: Foreground


@dataclass(frozen=True, eq=False, slots=True)
class GridInput(JoinedMessages):
    """
    Input of tracker `likelihood_grid`.

    Attributes
    ----------
    detections : Detections
        The targets of feedback, by which people are told apart.
    likelihood : Likelihood
        By edges.
    foreground : Foreground
        Unknown, where the camera is to tell edges alone.

    """

    COUNTED = 'likelihood'
    detections: Detections
    likelihood: Likelihood
    foreground: Foreground


@dataclass(frozen=True, eq=False, slots=True)
class BeliefInput(JoinedMessages):
    """
    Input of tracker `belief`.

    Attributes
    ----------
    detections : Detections
        By which targets start.
    belief : Belief
        By which they are tracked.

    """

    COUNTED = 'belief'
    detections: Detections
    belief: Belief
