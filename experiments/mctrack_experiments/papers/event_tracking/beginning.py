"""How soon those are told of who are there when the cameras begin to look (E1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mctrack_experiments.papers.event_tracking.happenings import (
    EventScore,
    Happening,
    score_events,
)
from mctrack_experiments.papers.event_tracking.tracked_match import TrackedMatch
from mctrack_ros.evaluation import evaluate_ground
from mctrack_ros.interfaces import EventCode

WINDOWS_S = (0.5, 2.0)
BEGINNING_S = 10.0


@dataclass(frozen=True, slots=True)
class Beginning:
    """
    The first `BEGINNING_S` of a match.

    Attributes
    ----------
    scores : tuple of EventScore
        Of E1, for each of `WINDOWS_S`.
    delays_s : tuple of float
        How long after each true E1 it was told, s; infinite if never.
    mota : float
        On the ground.

    """

    scores: tuple[EventScore, ...]
    delays_s: tuple[float, ...]
    mota: float

    @classmethod
    def of(cls, match: TrackedMatch, gate_m: float) -> Beginning:
        """Return the beginning of a tracked match."""
        truth, tracks = match.trajectories()
        frames = np.arange(round(BEGINNING_S * match.rate_hz)) + truth.frame.min()
        scores, delays_s = [EventScore()] * len(WINDOWS_S), []
        end_ns = match.start_ns + round(BEGINNING_S * 1e9)
        for camera in match.cameras:
            true, told = (
                [one for one in each if one.event == EventCode.NEW and one.stamp_ns < end_ns]
                for each in match.happenings(camera)
            )
            scores = [
                score + score_events(true, told, window_s, 1.0)
                for score, window_s in zip(scores, WINDOWS_S)
            ]
            delays_s += delays(true, told)
        mota = evaluate_ground(truth.at_frames(frames), tracks.at_frames(frames), gate_m).mota
        return cls(tuple(scores), tuple(delays_s), mota)


def delays(true: Sequence[Happening], told: Sequence[Happening]) -> list[float]:
    """Return how long after each true event one of the same targets was told first, s."""
    return [
        min(
            (
                (other.stamp_ns - one.stamp_ns) * 1e-9
                for other in told
                if other.targets == one.targets and other.stamp_ns >= one.stamp_ns
            ),
            default=float('inf'),
        )
        for one in true
    ]


def beginning_figures(prefix: str, matches: Sequence[Beginning]) -> dict[str, float]:
    """Return the figures of the beginnings of some matches."""
    figures: dict[str, float] = {}
    for index, window_s in enumerate(WINDOWS_S):
        score = sum((match.scores[index] for match in matches), EventScore())
        figures[f'{prefix}.e1.within_{1e3 * window_s:.0f}ms.f1'] = score.f1
    delays_s = [delay for match in matches for delay in match.delays_s]
    figures[f'{prefix}.e1.delay_median_s'] = float(np.median(delays_s))
    figures[f'{prefix}.mota'] = float(np.mean([match.mota for match in matches]))
    return figures
