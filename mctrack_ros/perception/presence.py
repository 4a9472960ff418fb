"""Who is in a camera's view: created, entered, left (events E1, E2 and E4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception.blobs import overlap
from mctrack_ros.perception.local_events import EventLog
from mctrack_ros.perception.local_tracks import LocalTracks
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PresenceConfig:
    """Parameters of `Presence`."""

    word_s: float = parameter(
        2.0, 'time that a new track waits for its global id before it is new [s]', minimum=0.0
    )
    enter_s: float = parameter(
        0.08, 'time for which an expected target is seen before it has entered [s]', minimum=0.0
    )
    gone_s: float = parameter(
        0.4, 'time for which a target is out of view before it has left [s]', minimum=0.0
    )
    covered_share: float = parameter(
        0.5,
        'share of an expected person that must be foreground to be seen',
        minimum=0.0,
        maximum=1.0,
    )


class Presence:
    """
    Tells once of each who comes and goes, through whatever local tracks stand for them.

    A target that the fusion node saw come from outside has entered once foreground is where it is
    expected (event-tracking paper, Algorithm 4, E2). Any other believed track is announced when it
    learns its global id: as entered if the fusion node knew the target before the track began,
    else as new (E1). Whoever is in view already only got another local track. A target has left
    (E4) when the fusion node has seen it outside for some time; without its word, when its track
    leaves.

    Parameters
    ----------
    config : PresenceConfig
        Parameters.
    extent : (2,) array
        Width and height of who is expected, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(
        self, config: PresenceConfig, extent: Floats, sizes: SizeTable, mapping: GroundMapping
    ) -> None:
        self._config, self._extent = config, extent
        self._sizes, self._mapping = sizes, mapping
        self._word_ns, self._gone_ns = round(config.word_s * 1e9), round(config.gone_s * 1e9)
        self._enter_ns = round(config.enter_s * 1e9)
        self._known_ns: dict[int, int] = {}
        self.restart()

    def restart(self) -> None:
        """Forget who is in view."""
        self._announced: set[int] = set()
        self._present_ns: dict[int, int] = {}
        self._outside: set[int] = set()
        self._entering_ns: dict[int, int] = {}

    def announce(
        self,
        tracks: LocalTracks,
        feedback: Feedback | None,
        blob_box: Floats,
        stamp_ns: int,
        log: EventLog,
    ) -> None:
        """
        Note who is new (E1), who entered (E2) and who left (E4).

        Parameters
        ----------
        tracks : LocalTracks
            With the ids that feedback taught them.
        feedback : Feedback or None
            The fusion node's; without, believed tracks are new at once.
        blob_box : (m, 4) array
            Foreground, px.
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
            self._follow(feedback, blob_box, stamp_ns, log)
        names, targets = tracks.local_id.tolist(), tracks.track_id.tolist()
        for row in np.flatnonzero(tracks.confirmed).tolist():
            local, target = names[row], targets[row]
            if local not in self._announced:
                waiting = stamp_ns - tracks.first_ns[row] < self._word_ns
                if not target and waiting and feedback is not None:
                    continue
                self._announced.add(local)
                if target not in self._present_ns and target not in self._outside:
                    known = self._known_ns.get(target, stamp_ns) < tracks.first_ns[row]
                    log.add(EventCode.ENTER if known else EventCode.NEW, tracks, row)
            if target and target not in self._outside:
                self._present_ns.setdefault(target, stamp_ns)
        self._announced.intersection_update(names)

    def left(self, tracks: LocalTracks, row: int, log: EventLog) -> None:
        """Note that a local track has left the picture (E4), if the fusion node will not tell."""
        known = int(tracks.track_id[row]) in self._present_ns
        if int(tracks.local_id[row]) in self._announced and not known:
            log.add(EventCode.EXIT, tracks, row)

    def _follow(self, feedback: Feedback, blob_box: Floats, stamp_ns: int, log: EventLog) -> None:
        """Note which of the fusion node's targets come into view and which leave it."""
        foot = self._expected(feedback, stamp_ns)
        with np.errstate(invalid='ignore'):
            inside = np.asarray(((foot >= 0) & (foot < self._mapping.image_size)).all(axis=1))
        ids = feedback.track_id.tolist()
        for row, (target, is_inside) in enumerate(zip(ids, inside.tolist())):
            if not is_inside:
                self._outside.add(target)
            if target in self._present_ns:
                self._stay(target, is_inside, feedback.position[row], stamp_ns, log)
            elif is_inside and target in self._outside and self._is_seen(foot[row], blob_box):
                since_ns = self._entering_ns.setdefault(target, stamp_ns)
                if stamp_ns - since_ns >= self._enter_ns:
                    log.add_target(EventCode.ENTER, target, feedback.position[row])
                    self._present_ns[target] = stamp_ns
                    self._outside.discard(target)
            else:
                self._entering_ns.pop(target, None)
        for store in (self._present_ns, self._entering_ns):
            for target in store.keys() - set(ids):
                del store[target]
        self._outside.intersection_update(ids)

    def _stay(
        self,
        target: int,
        inside: bool,
        position: NDArray[np.floating],
        stamp_ns: int,
        log: EventLog,
    ) -> None:
        self._entering_ns.pop(target, None)
        if inside:
            self._present_ns[target] = stamp_ns
            self._outside.discard(target)
        elif stamp_ns - self._present_ns[target] >= self._gone_ns:
            del self._present_ns[target]
            log.add_target(EventCode.EXIT, target, position)

    def _expected(self, feedback: Feedback, stamp_ns: int) -> Floats:
        """Return the (n, 2) foot points, px, at which targets are expected."""
        seconds = (stamp_ns - feedback.stamp_ns) * 1e-9
        place = feedback.position[:, :2] + feedback.velocity * seconds
        return self._mapping.image_from_ground(place.astype(np.float64))

    def _is_seen(self, foot: Floats, blob_box: Floats) -> bool:
        """Tell whether there is foreground where a person at a (2,) foot point would be."""
        box = self._sizes.box_of(foot[None], self._extent[None])
        width, height = self._mapping.image_size
        shown = overlap(box, np.array([[0.0, 0.0, width, height]]))[0, 0]
        covered = overlap(box, blob_box).max(initial=0.0)
        return bool(covered > 0 and covered >= self._config.covered_share * shown)
