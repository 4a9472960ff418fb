"""Which rows of truth and tracks `mctrack evaluate` counts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.affinity import translate

from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.interfaces import ClassCode, Tracks
from mctrack_ros.site.stated_origin import Origin


@dataclass(frozen=True, slots=True)
class Selection:
    """
    What is scored.

    Attributes
    ----------
    area : str
        As `mctrack_ros.ground.coverage.coverage.area_from` reads it; empty: everywhere.
    start_s, stop_s : float
        From when until before when, s since the tracks begin.
    class_id : ClassCode, optional
        Of whom; unless given, of all.

    """

    area: str = ''
    start_s: float = -math.inf
    stop_s: float = math.inf
    class_id: ClassCode | None = None

    def protocol(self) -> dict[str, str]:
        """Return what was selected, by name."""
        said = {}
        if self.area:
            said['area'] = f'{self.area} m; rows outside are left out, of truth and tracks alike'
        if math.isfinite(self.start_s) or math.isfinite(self.stop_s):
            said['span'] = f'{self.start_s:g} to {self.stop_s:g} s'
        if self.class_id is not None:
            said['class'] = self.class_id.name.lower()
        return said

    def options(self) -> str:
        """Return the options of the command that select so, each after a blank."""
        texts = [f' --area={self.area}'] if self.area else []
        texts += [f' --from {self.start_s:g}'] if math.isfinite(self.start_s) else []
        texts += [f' --to {self.stop_s:g}'] if math.isfinite(self.stop_s) else []
        if self.class_id is not None:
            texts.append(f' --class {self.class_id.name.lower()}')
        return ''.join(texts)

    def of_area(self, instants: Sequence[Tracks], origin: Origin) -> tuple[Tracks, ...]:
        """Return the rows, relative to an origin, that stand in the area or on its edge."""
        if not self.area:
            return tuple(instants)
        area = translate(area_from(self.area), *np.negative(origin))
        shapely.prepare(area)
        inside = (
            shapely.intersects_xy(area, rows.position[:, :2].astype(float)) for rows in instants
        )
        return tuple(rows.select(kept) for rows, kept in zip(instants, inside))

    def in_span(self, seconds: NDArray[np.float64], period_s: float) -> NDArray[np.bool_]:
        """Tell which frames count that are at so many seconds, up to what rounding does."""
        rounding = 0.01 * period_s
        after: NDArray[np.bool_] = seconds >= self.start_s - rounding
        return after & (seconds < self.stop_s - rounding)


def says_classes(instants: Sequence[Tracks]) -> bool:
    """Tell whether there is a class of anybody."""
    return any(rows.class_id.any() for rows in instants)


def of_class(instants: Sequence[Tracks], code: ClassCode) -> tuple[Tracks, ...]:
    """
    Return the tracks of a class: the one that most of their rows say, but for unknown.

    Parameters
    ----------
    instants : sequence of Tracks
        All.
    code : ClassCode
        Which.

    """
    pairs = [np.column_stack([rows.track_id, rows.class_id]).astype(np.int64) for rows in instants]
    found = np.concatenate([np.zeros((0, 2), np.int64), *pairs])
    ids, which = np.unique(found[:, 0], return_inverse=True)
    count = np.zeros((len(ids), 256), np.int64)
    np.add.at(count, (which, found[:, 1]), 1)
    count[:, ClassCode.UNKNOWN] = 0
    likeliest = np.where(count.any(axis=1), count.argmax(axis=1), ClassCode.UNKNOWN)
    wanted = ids[likeliest == code]
    return tuple(rows.select(np.isin(rows.track_id, wanted)) for rows in instants)
