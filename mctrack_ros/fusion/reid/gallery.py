"""What those who are tracked look like, and how much one may differ from himself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import TEMPLATE_SIZE

Floats = NDArray[np.float64]

TRUST_S = 1.0
"""Time for which one must be seen for his colours to count half, s; this and the next two were
chosen on the tuning matches of the pitch."""

STRANGE = 4.0
"""What the colours of two people usually differ by, in variances of one."""

MEMORY_S = 20.0
"""Time in view, of all cameras together, that is remembered of somebody's colours, s."""

USUAL_VARIANCE = 3e-4
"""Of each bin of the mean root of somebody's templates, before it is known."""

SCATTER_PRIOR_S = 10.0
"""How long people must be seen for what is learned to count as much as that, s."""

RIDGE = 0.3
"""Share of it that every bin varies by whatever is learned."""

SURE_S = 2.0
"""A portrait of less than so long tells nothing of how much people differ from themselves, s."""


@dataclass(frozen=True, slots=True)
class AppearanceSample:
    """
    Somebody's colours, of all cameras together.

    Attributes
    ----------
    mean : (48,) array
        Mean of the roots of his templates: their distance is the Hellinger distance.
    seconds : float
        For how long he was seen, each camera's time added, s.

    """

    mean: Floats
    seconds: float


class Gallery:
    """
    The colours of everybody by id, learned while he is surely himself.

    Looks are compared by how much people differ from themselves (light, place, stride): the
    covariance within a person is learned from all of them and divided out (within-class
    covariance normalisation, Hatch and Stolcke 2006).
    """

    def __init__(self) -> None:
        self._known: dict[int, AppearanceSample] = {}
        self._scatter = np.zeros((TEMPLATE_SIZE, TEMPLATE_SIZE))
        self._scatter_s = 0.0
        self._whitening: Floats | None = None

    def __contains__(self, track_id: int) -> bool:
        """Tell whether it is known what somebody looks like."""
        return track_id in self._known

    def names(self) -> set[int]:
        """Return the ids that have a portrait."""
        return set(self._known)

    def learn(self, track_id: int, look: AppearanceSample) -> None:
        """Mix a look at somebody into his portrait."""
        old = self._known.get(track_id)
        if old is None:
            self._known[track_id] = look
            return
        if old.seconds >= SURE_S:
            change = look.mean - old.mean
            self._scatter += look.seconds * np.outer(change, change)
            self._scatter_s += look.seconds
            self._whitening = None
        seconds = min(old.seconds, MEMORY_S) + look.seconds
        mean = old.mean + (look.mean - old.mean) * look.seconds / seconds
        self._known[track_id] = AppearanceSample(mean, seconds)

    def forget(self, track_id: int) -> None:
        """Forget what somebody looks like."""
        self._known.pop(track_id, None)

    def weight(self, look: AppearanceSample) -> float:
        """Return how much a look tells, 0 to 1: less the shorter it is and the less is learned."""
        if look.seconds == 0.0 or self._scatter_s == 0.0:
            return 0.0
        doubt = TRUST_S * (1 / look.seconds + SCATTER_PRIOR_S / self._scatter_s)
        return 1.0 / (1.0 + doubt)

    def difference(self, look: AppearanceSample, track_id: int) -> float:
        """
        Return how much a look differs from somebody's portrait, 0.5 to 1 for his own.

        The less he is known, the less it takes for him to look different.
        """
        portrait = self._known.get(track_id)
        if portrait is None:
            return STRANGE
        doubt = TRUST_S / portrait.seconds
        return self.distance(look.mean, track_id) / (1.0 + doubt)

    def distance(self, look: Floats, track_id: int) -> float:
        """Return the squared distance of colours, (48,), and those of one who is known."""
        change = self.whitened(look - self._known[track_id].mean)
        return float(change @ change)

    def whitened(self, root: Floats) -> Floats:
        """
        Return roots of templates, (..., 48), scaled so that squared distances are of variance 1.

        That is, of two images of one person: the mean over the bins.
        """
        if self._whitening is None:
            self._whitening = np.asarray(np.linalg.cholesky(self._metric()), np.float64)
        return np.asarray(root @ self._whitening)

    def _metric(self) -> Floats:
        total_s = SCATTER_PRIOR_S + self._scatter_s
        usual = USUAL_VARIANCE * (SCATTER_PRIOR_S / total_s + RIDGE)
        within = self._scatter / total_s + usual * np.eye(TEMPLATE_SIZE)
        return np.linalg.inv(within) / TEMPLATE_SIZE
