"""Which cameras share no view: learned from who is seen together."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, BOOLS_2D, compiled

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

TURNS = 8
"""Each track is looked at in one of so many ticks."""
LEAST_SHARE = 0.02
"""Share of what another camera sees below which two have no view in common."""
PRIOR_S = 2.0
"""How long they must be watched to say as much as what is assumed, s."""
MEMORY_S = 1000.0
"""What was watched longer ago counts less and less, s."""


class ViewOverlap:
    """
    For each pair of cameras, how much of what one sees the other does.

    The misses of one camera at places that it never looked at are no independent witnesses: as
    many cameras as there are would speak against all that one alone sees. Pairs that never see
    anybody together share no view.

    Parameters
    ----------
    cameras : int
        How many there are.

    Attributes
    ----------
    together, watched : (cameras, cameras) arrays
        For how long what the first saw was seen by the second, and could be, s.

    """

    def __init__(self, cameras: int) -> None:
        self.together = np.zeros((cameras, cameras))
        self.watched = np.zeros((cameras, cameras))
        self._turn = 0

    def share(self) -> Floats:
        """
        Return by what to multiply what is assumed of each second camera, (cameras, cameras).

        1: they see somebody together now and then, or it is not known yet.
        """
        usual = self.together / LEAST_SHARE
        return np.asarray(np.minimum((PRIOR_S + usual) / (PRIOR_S + self.watched), 1.0))

    def learn(self, seen: Mask, could: Mask, sure: Mask, seconds: float) -> None:
        """
        Note who is seen together.

        Parameters
        ----------
        seen, could : (n, cameras) bool arrays
            Which cameras saw each track in a tick, and which others could have.
        sure : (n,) bool array
            Which tracks have been there for long enough to tell.
        seconds : float
            For how long that speaks, s.

        """
        self._turn = (self._turn + 1) % TURNS
        _learn(seen, could, sure, self._turn, TURNS * seconds, self.together, self.watched)
        if self.watched.max(initial=0.0) > MEMORY_S:
            self.together /= 2
            self.watched /= 2


@compiled(
    types.void(
        BOOLS_2D, BOOLS_2D, BOOLS_1D, types.i8, types.f8, types.f8[:, ::1], types.f8[:, ::1]
    )
)
def _learn(
    seen: Mask, could: Mask, sure: Mask, turn: int, seconds: float, together: Floats,
    watched: Floats,
) -> None:  # fmt: skip
    cameras = seen.shape[1]
    for row in range(turn, len(seen), TURNS):
        for one in range(cameras if sure[row] else 0):
            for other in range(cameras if seen[row, one] else 0):
                if other != one and (seen[row, other] or could[row, other]):
                    watched[one, other] += seconds
                    together[one, other] += seconds if seen[row, other] else 0.0
