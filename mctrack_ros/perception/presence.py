"""Who is in a camera's view: created, entered, left (events E1, E2 and E4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception.local_events import EventLog
from mctrack_ros.perception.local_tracks import LocalTracks


@dataclass(frozen=True)
class PresenceConfig:
    """Parameters of `Presence`."""

    word_s: float = parameter(
        0.6, 'time that a new track waits for its global id before it is new [s]', minimum=0.0
    )
    gone_s: float = parameter(
        0.4, 'time for which a lost target is out of view before it has left [s]', minimum=0.0
    )


class Presence:
    """
    Tells once of each who comes and goes, through whatever local tracks stand for them.

    A believed track is announced when it learns its global id: as entered if the fusion node knew
    the target before the track began, else as new (event-tracking paper, Algorithm 4, E1 and E2).
    Whoever is in view already only got another local track, and is not announced. A target whose
    track was lost has left when the fusion node sees it out of view.

    Parameters
    ----------
    config : PresenceConfig
        Parameters.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(self, config: PresenceConfig, mapping: GroundMapping) -> None:
        self._word_ns, self._gone_ns = round(config.word_s * 1e9), round(config.gone_s * 1e9)
        self._mapping = mapping
        self._known_ns: dict[int, int] = {}
        self.restart()

    def restart(self) -> None:
        """Forget who is in view."""
        self._announced: set[int] = set()
        self._present_ns: dict[int, int] = {}

    def announce(
        self, tracks: LocalTracks, feedback: Feedback | None, stamp_ns: int, log: EventLog
    ) -> None:
        """
        Note who is new (E1) and who entered (E2).

        Parameters
        ----------
        tracks : LocalTracks
            With the ids that feedback taught them.
        feedback : Feedback or None
            The fusion node's; without, believed tracks are new at once.
        stamp_ns : int
            Time of the picture, ns.
        log : EventLog
            Takes the events.

        """
        if feedback is not None:
            self._known_ns = {
                target: self._known_ns.get(target, feedback.stamp_ns)
                for target in feedback.track_id.tolist()
            }
        for row in np.flatnonzero(tracks.confirmed).tolist():
            local, target = int(tracks.local_id[row]), int(tracks.track_id[row])
            if local not in self._announced:
                waiting = stamp_ns - tracks.first_ns[row] < self._word_ns
                if not target and waiting and feedback is not None:
                    continue
                self._announced.add(local)
                if target not in self._present_ns:
                    known = self._known_ns.get(target, stamp_ns) < tracks.first_ns[row]
                    log.add(EventCode.ENTER if known else EventCode.NEW, tracks, row)
            if target:
                self._present_ns[target] = stamp_ns
        self._announced &= set(tracks.local_id.tolist())
        if feedback is not None:
            self._note_gone(feedback, stamp_ns, log)

    def left(self, tracks: LocalTracks, row: int, log: EventLog) -> None:
        """Note that the target of a local track has left the picture (E4)."""
        if int(tracks.local_id[row]) in self._announced:
            log.add(EventCode.EXIT, tracks, row)
            self._present_ns.pop(int(tracks.track_id[row]), None)

    def _note_gone(self, feedback: Feedback, stamp_ns: int, log: EventLog) -> None:
        """Note which lost targets the fusion node sees out of view."""
        foot = self._mapping.image_from_ground(feedback.position[:, :2].astype(np.float64))
        with np.errstate(invalid='ignore'):
            inside = ((foot >= 0) & (foot < self._mapping.image_size)).all(axis=1)
        ids = feedback.track_id.tolist()
        for target in set(feedback.track_id[inside].tolist()) & self._present_ns.keys():
            self._present_ns[target] = stamp_ns
        for target, last_ns in [*self._present_ns.items()]:
            if stamp_ns - last_ns >= self._gone_ns:
                del self._present_ns[target]
                if target in ids:
                    log.add_target(EventCode.EXIT, target, feedback.position[ids.index(target)])
