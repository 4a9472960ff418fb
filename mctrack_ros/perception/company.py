"""Everybody in a camera's view: its own tracks and the fusion node's targets, each once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
NO_FEEDBACK = Feedback.build(0)


@dataclass(frozen=True)
class CompanyConfig:
    """Parameters of `Roll`."""

    same_m: float = parameter(
        1.0, 'distance within which a local track and a target may be one person [m]', minimum=0.0
    )
    sure_s: float = parameter(
        0.4, 'age from which a local track that is no target is a person [s]', minimum=0.0
    )
    sure_share: float = parameter(
        0.35,
        'share of the body that such a track must explain alone',
        minimum=0.0,
        maximum=1.0,
    )
    memory_s: float = parameter(
        1.0, 'time for which targets are predicted without new feedback [s]', minimum=0.0
    )


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """
    Local tracks that are believed, as they are seen in one picture, one row each.

    Attributes
    ----------
    local_id : (n,) int64 array
        Ascending.
    position : (n, 2) float64 array
        Where they are expected, m.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    seen : (n,) bool array
        In this picture.
    proven : (n,) float64 array
        Share of the body that explains what no older track does.
    age_s : (n,) float64 array
        Since they began, s.

    """

    local_id: Ints
    position: Floats
    box: Floats
    seen: Booleans
    proven: Floats
    age_s: Floats


@dataclass(frozen=True, eq=False, slots=True)
class Company:
    """
    Persons in view, one row each, ascending by key.

    Attributes
    ----------
    key : (n,) int64 array
        The global id; minus the local one where there is none.
    local_id, track_id : (n,) int64 array
        The camera's own track and the global one; 0: none.
    position : (n, 2) float64 array
        On the ground, m.
    box : (n, 4) float64 array
        Where they are, or else should be, px; not finite: not seen.
    came : (n,) bool array
        Stepped into the picture just now.

    """

    key: Ints
    local_id: Ints
    track_id: Ints
    position: Floats
    box: Floats
    came: Booleans


NOBODY = Company(
    np.zeros(0, np.int64),
    np.zeros(0, np.int64),
    np.zeros(0, np.int64),
    np.zeros((0, 2)),
    np.zeros((0, 4)),
    np.zeros(0, np.bool_),
)


class Roll:
    """
    Calls the roll: the fusion node's targets in view, and local tracks that are none of them.

    Who has no local track, because others hide him, is of the company all the same, where the
    fusion node expects him (event-tracking paper, R2, R3 and R5: what it knows is registered). A
    target and a local track are one by where they are now, not by what they were once.

    Parameters
    ----------
    config : CompanyConfig
        Parameters.
    extent : (2,) array
        Width and height of who is expected, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(
        self, config: CompanyConfig, extent: Floats, sizes: SizeTable, mapping: GroundMapping
    ) -> None:
        self._config, self._extent = config, extent
        self._sizes, self._mapping = sizes, mapping
        self.restart()

    def restart(self) -> None:
        """Forget who was in view."""
        self._feedback = NO_FEEDBACK
        self._outside: set[int] = set()

    def call(self, local: Sighting, feedback: Feedback | None, stamp_ns: int) -> Company:
        """
        Return who is in view.

        Parameters
        ----------
        local : Sighting
            The camera's own tracks.
        feedback : Feedback or None
            The fusion node's; without, the last one counts for a while, then all local tracks do.
        stamp_ns : int
            Time of the picture, ns.

        """
        self._feedback = feedback or self._feedback
        seconds = (stamp_ns - self._feedback.stamp_ns) * 1e-9
        if seconds > self._config.memory_s:
            return self._alone(local)
        place, target = self._expected(seconds)
        mine, theirs = self._pairs(local, place)
        foot = self._mapping.image_from_ground(place)
        box = self._sizes.box_of(foot, np.repeat(self._extent[None], len(foot), axis=0))
        box[theirs] = local.box[mine]
        local_id = np.zeros(len(target), np.int64)
        local_id[theirs] = local.local_id[mine]
        inside = self._inside(foot)
        came = inside & np.array([each in self._outside for each in target.tolist()], bool)
        self._outside = set(target[~inside].tolist())
        others = self._others(local, mine)
        joined = Company(
            np.concatenate([target[inside], -local.local_id[others]]),
            np.concatenate([local_id[inside], local.local_id[others]]),
            np.concatenate([target[inside], np.zeros(len(others), np.int64)]),
            np.concatenate([place[inside], local.position[others]]),
            np.concatenate([box[inside], local.box[others]]),
            np.concatenate([came[inside], np.zeros(len(others), np.bool_)]),
        )
        return _ordered(joined)

    def _alone(self, local: Sighting) -> Company:
        """Return the company as the camera knows it without the fusion node."""
        box = np.where(local.seen[:, None], local.box, np.nan)
        nobody = np.zeros(len(box), np.int64)
        came = np.ones(len(box), np.bool_)
        here = Company(-local.local_id, local.local_id, nobody, local.position, box, came)
        return _ordered(here)

    def _expected(self, seconds: float) -> tuple[Floats, Ints]:
        """Return where the targets should be by now, (n, 2) m, and their ids."""
        feedback = self._feedback
        place = feedback.position[:, :2] + feedback.velocity * seconds
        return place.astype(np.float64), feedback.track_id.astype(np.int64)

    def _pairs(self, local: Sighting, place: Floats) -> tuple[Ints, Ints]:
        """Return rows of local tracks and of targets that are one person."""
        seen = np.flatnonzero(local.seen)
        gap = local.position[seen, None] - place[None]
        distance = np.hypot(gap[..., 0], gap[..., 1])
        row, column = linear_sum_assignment(np.minimum(distance, self._config.same_m))
        fits = distance[row, column] < self._config.same_m
        return seen[row[fits]], np.asarray(column[fits], np.int64)

    def _others(self, local: Sighting, taken: Ints) -> Ints:
        """Return rows of local tracks that are surely somebody whom the fusion node misses."""
        sure = local.seen & (local.proven >= self._config.sure_share)
        sure &= local.age_s >= self._config.sure_s
        sure[taken] = False
        rows = np.flatnonzero(sure)
        return rows[self._inside(self._sizes.foot_of(local.box[rows]))]

    def _inside(self, foot: Floats) -> Booleans:
        with np.errstate(invalid='ignore'):
            return np.asarray(((foot >= 0) & (foot <= self._mapping.image_size)).all(axis=1))


def _ordered(company: Company) -> Company:
    order = np.argsort(company.key)
    return Company(
        company.key[order],
        company.local_id[order],
        company.track_id[order],
        company.position[order],
        company.box[order],
        company.came[order],
    )
