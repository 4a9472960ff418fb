"""Identity hypotheses: the targets that each track may be, after it met others."""

from __future__ import annotations

from collections.abc import Iterable


class IdHypotheses:
    """For every track, by its present id, the ids of all whom it may be."""

    def __init__(self) -> None:
        self._of: dict[int, frozenset[int]] = {}

    def of(self, track_id: int) -> frozenset[int]:
        """Return whom a track may be: himself, unless he met others."""
        return self._of.get(track_id, frozenset([track_id]))

    def meet(self, first: int, second: int) -> None:
        """Either may be the other from now on, and whoever that one may be."""
        one, other = self.of(first), self.of(second)
        if one != other:
            self._of[first] = self._of[second] = one | other

    def settle(self, track_id: int, may_be: Iterable[int]) -> None:
        """Say whom a track may be."""
        self._of[track_id] = frozenset(may_be) | {track_id}

    def end(self, track_id: int) -> None:
        """Forget whom a track may be; others may still be him."""
        self._of.pop(track_id, None)

    def become(self, old: int, new: int) -> None:
        """Replace an identity by another in all hypotheses: the first turned out to be nobody."""
        for one, may_be in self._of.items():
            if old in may_be:
                self._of[one] = may_be - {old} | {new}

    def erase(self, track_ids: Iterable[int]) -> None:
        """Remove identities from all hypotheses."""
        gone = frozenset(track_ids)
        if not gone:
            return
        for one in gone:
            self.end(one)
        for other, may_be in self._of.items():
            if not gone.isdisjoint(may_be):
                self._of[other] = may_be - gone

    def connected(self, seed: int, present: Iterable[int]) -> list[int]:
        """Return those present, ascending, who may be one another by way of others, with one."""
        connected, names, rest = {seed}, set(self.of(seed)), set(present) - {seed}
        while joined := {one for one in rest if not names.isdisjoint(self.of(one))}:
            connected |= joined
            rest -= joined
            names.update(*(self.of(one) for one in joined))
        return sorted(connected)
