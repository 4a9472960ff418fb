"""Operator-perceived activity: true and tracked numbers of events (silhouettes, Table 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class ActivityTable:
    """
    How many events there were with so many true and so many tracked objects.

    Attributes
    ----------
    counts : (true + 1, tracked + 1) int array
        Rows: the true number; columns: what the tracker counted.

    """

    counts: Ints

    def __post_init__(self) -> None:
        """Refuse what is no table."""
        counts = self.counts
        if counts.ndim != 2 or (counts < 0).any() or (counts.size and counts[0, 0]):
            raise ValueError(
                f'counts has shape {counts.shape}, expected a table of numbers from 0 '
                'with nothing where nothing was and nothing was tracked'
            )

    @classmethod
    def of(cls, pairs: list[tuple[int, int]]) -> ActivityTable:
        """Return the table of events, each a true and a tracked number."""
        size = 1 + np.array([(0, 0), *pairs]).max(axis=0)
        counts = np.zeros(size, np.int64)
        for true, tracked in pairs:
            counts[true, tracked] += 1
        return cls(counts)

    def __add__(self, other: ActivityTable) -> ActivityTable:
        """Return the table of the events of both."""
        shape = np.maximum(self.counts.shape, other.counts.shape)
        counts = np.zeros(shape, np.int64)
        for table in (self.counts, other.counts):
            counts[: table.shape[0], : table.shape[1]] += table
        return ActivityTable(counts)

    @property
    def events(self) -> int:
        """Number of events, false ones among them."""
        return int(self.counts.sum())

    @property
    def perfect(self) -> int:
        """Events with as many tracked as true: the main diagonal."""
        return int(np.trace(self.counts))

    @property
    def lost(self) -> int:
        """Events with fewer tracked than true: below the main diagonal."""
        return int(np.tril(self.counts, -1).sum())

    @property
    def over_tracked(self) -> int:
        """Events with more tracked than true, where something was."""
        return int(np.triu(self.counts, 1)[1:].sum())

    @property
    def false(self) -> int:
        """Events that the tracker alone perceived: the first row."""
        return int(self.counts[0].sum())

    @property
    def passed(self) -> tuple[int, int]:
        """
        Events tracked perfectly, and all that lie on or below the diagonal.

        For pedestrians the paper's rate of those passed on to the classifier (section 6): above
        the diagonal are tracks that are too short to be passed on.
        """
        return self.perfect, self.perfect + self.lost

    def text(self, columns: int = 6) -> str:
        """Return the table as aligned lines, true numbers down, tracked ones across."""
        counts = self.counts
        names = [str(column) for column in range(counts.shape[1])]
        if len(names) > columns:
            rest = counts[:, columns - 1 :].sum(axis=1, keepdims=True)
            counts = np.concatenate([counts[:, : columns - 1], rest], axis=1)
            names = [*names[: columns - 1], f'{columns - 1}+']
        rows = [('', names), *((str(true), row) for true, row in enumerate(counts.tolist()))]
        return '\n'.join(
            f'{name:>4}' + ''.join(f'{cell:>6}' for cell in row) for name, row in rows
        )


def wilson_interval(successes: int, trials: int, deviations: float = 1.96) -> tuple[float, float]:
    """
    Return the interval in which a proportion lies (E. B. Wilson, 1927).

    Parameters
    ----------
    successes, trials : int
        What was counted.
    deviations : float
        Half width in standard deviations; 1.96: 95 %.

    """
    if trials == 0:
        return 0.0, 1.0
    square = deviations**2 / trials
    share = successes / trials
    middle = (share + square / 2) / (1 + square)
    spread = deviations * np.sqrt(share * (1 - share) / trials + square / (4 * trials))
    half = float(spread / (1 + square))
    return max(middle - half, 0.0), min(middle + half, 1.0)
