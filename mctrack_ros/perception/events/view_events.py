"""What happens to everybody in a camera's view (event-tracking paper, Table 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.blobs.touching import contacts
from mctrack_ros.perception.events.appearance_events import AppearanceEvents
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.groups import GroupConfig, Groups
from mctrack_ros.perception.feedback.persons_in_view import (
    NO_PERSONS,
    ConfirmedTracks,
    PersonList,
)
from mctrack_ros.perception.geometry.person_size import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NO_TRACKS: Ints = np.zeros(0, np.int64)
Booleans = NDArray[np.bool_]


class ViewEvents:
    """
    Notes who comes and leaves (E1, E2, E4), who meets and parts (E5, E3) and who is alone (E6).

    Parameters
    ----------
    config : GroupConfig
        Parameters.
    extent : (2,) array
        Width and height of who is expected, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    Attributes
    ----------
    in_view : PersonsInView
        Everybody in the last image.
    appearance : AppearanceEvents
        Notes who comes and leaves.

    """

    def __init__(
        self, config: GroupConfig, extent: Floats, sizes: SizeTable, mapping: GroundMapping
    ) -> None:
        self.in_view = NO_PERSONS
        self.appearance = AppearanceEvents(extent, sizes, mapping)
        self._persons = PersonList(extent, sizes, mapping)
        self._groups, self._stable = Groups(config), StableEvents(config.stable_s)

    def restart(self) -> None:
        """Forget everybody."""
        self.in_view = NO_PERSONS
        self.appearance.restart()
        self._persons.restart()
        self._groups.restart()
        self._stable.restart()

    def group(
        self,
        local: ConfirmedTracks,
        blob_box: Floats,
        frame: Frame,
        feedback: Feedback | None,
        stamp_ns: int,
        log: EventLog,
        tracked: Ints = NO_TRACKS,
    ) -> Ints:
        """
        Note who joined a group (E5), who left one (E3) and who is stable (E6) (Definition 6).

        Parameters
        ----------
        local : ConfirmedTracks
            The camera's own.
        blob_box : (m, 4) array
            Foreground, px.
        frame : Frame
            The image with its foreground.
        feedback : Feedback or None
            The fusion node's.
        stamp_ns : int
            Time of the image, ns.
        log : EventLog
            Takes the events.
        tracked : (k,) int64 array
            Global ids of those who are tracked here without one of the camera's own.

        Returns
        -------
        (n,) int64 array
            The part of the foreground that each person in view is of; -1: not seen.

        """
        if feedback is not None:
            self._groups.rename(feedback.corrections())
        in_view = self.in_view = self._persons.update(local, feedback, stamp_ns)
        part = contacts(in_view.box, blob_box, frame)
        for change in self._groups.step(in_view.key, part, stamp_ns, ~in_view.came):
            code = EventCode.MERGE if change.merged else EventCode.SPLIT
            rows = (
                np.searchsorted(in_view.key, change.part),
                np.searchsorted(in_view.key, change.rest),
            )
            log.add_group(code, in_view, *rows)
        alone = (in_view.local_id > 0) | np.isin(in_view.track_id, tracked)
        alone &= (self._groups.sizes() == 1) & (part >= 0)
        for row in self._stable.step(in_view.key, alone, stamp_ns):
            log.add_group(EventCode.STABLE, in_view, np.array([row]), np.zeros(0, np.int64))
        return part

    def groups(self) -> list[Ints]:
        """Return the rows in view of the members of each group."""
        key = self.in_view.key
        return [np.searchsorted(key, keys) for keys in self._groups.members()]


class StableEvents:
    """
    Tells once of each who has been alone for a while, after whatever else happened to him.

    Every other event takes precedence (event-tracking paper, Table 1 and Algorithm 4): whoever
    comes, merges, or splits off is not stable until he has been tracked alone for some time.

    Parameters
    ----------
    stable_s : float
        How long, s.

    """

    def __init__(self, stable_s: float) -> None:
        self._stable_ns = round(stable_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget who is stable."""
        self._since_ns: dict[int, int] = {}
        self._reported: set[int] = set()

    def step(self, key: Ints, alone: Booleans, stamp_ns: int) -> list[int]:
        """
        Return the rows of those who are stable from now on.

        Parameters
        ----------
        key : (n,) int64 array
            Of everybody in view.
        alone : (n,) bool array
            Who is tracked in this image, in no group.
        stamp_ns : int
            Time of the image, ns.

        """
        rows = dict(zip(key[alone].tolist(), np.flatnonzero(alone).tolist()))
        self._since_ns = {one: self._since_ns.get(one, stamp_ns) for one in rows}
        self._reported &= rows.keys()
        ripe = [
            one
            for one, since_ns in self._since_ns.items()
            if one not in self._reported and stamp_ns - since_ns >= self._stable_ns
        ]
        self._reported.update(ripe)
        return [rows[one] for one in ripe]
