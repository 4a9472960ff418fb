"""Appearance events of a camera: created, entered, left (E1, E2 and E4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception.blobs.extraction import overlap
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import LocalTracks

Floats = NDArray[np.float64]


SILENCE_NS = 2_000_000_000
"""Silence of the fusion node after which the camera decides who is new: many of its periods."""
ENTER_NS = 80_000_000
"""Time for which an expected target is seen before it has entered: two images."""
GONE_NS = 400_000_000
"""Time for which a target is out of view before it has left: as groups part (`groups.part_s`)."""
START_NS = 600_000_000
"""Time at the start in which every target is new: until the fusion node has confirmed tracks."""
AGAIN_NS, AGAIN_M, AGAIN_M_S = 10_000_000_000, 2.0, 2.0
"""Time in which one who was lost may turn up by another id, how far away at once, and how much
farther with time: a person who runs."""
BESIDE_M = 2.5
"""A target that first appears this near to another was hidden by it; simulated matches."""
COVERED_SHARE = 0.5  # of an expected person that must be foreground to be seen: most of him


class AppearanceEvents:
    """
    Reports each target's coming and going once, whichever local tracks stand for it.

    A target of the fusion node is in view once foreground is where it is expected. It has entered
    if the fusion node saw it come from outside, or knew it before this camera asked
    (event-tracking paper, Algorithm 4, E2); else it is new (E1), unless it is another name for one
    just lost, or was hidden by another (those R3 claims). A target has left (E4) when the fusion
    node has seen it outside for some time. While feedback arrives, a local track without a target
    gives no event: it is a part of somebody, or a ghost. While none arrives, each confirmed local
    track without a target is new, and has left when the track ends.

    Parameters
    ----------
    extent : (2,) array
        Width and height of who is expected, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(self, extent: Floats, sizes: SizeTable, mapping: GroundMapping) -> None:
        self._extent, self._sizes, self._mapping = extent, sizes, mapping
        self.restart()

    def restart(self) -> None:
        """Forget who is in view."""
        self._announced: set[int] = set()
        self._unheard: set[int] = set()
        self._heard_ns: int | None = None
        self._present_ns: dict[int, int] = {}
        self._outside: set[int] = set()
        self._entering_ns: dict[int, int] = {}
        self._place: dict[int, Floats] = {}
        self._lost: dict[int, tuple[int, Floats]] = {}
        self._old: set[int] | None = None
        self._new_until_ns = 0

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
            The fusion node's; if there was none for long, confirmed tracks are new at once.
        blob_box : (m, 4) array
            Foreground, px.
        stamp_ns : int
            Time of the image, ns.
        log : EventLog
            Takes the events.

        """
        if feedback is not None:
            self.follow(feedback, blob_box, stamp_ns, log)
        silent = self._heard_ns is None or stamp_ns - self._heard_ns >= SILENCE_NS
        names, targets = tracks.local_id.tolist(), tracks.track_id.tolist()
        for row in np.flatnonzero(tracks.confirmed).tolist():
            local, target = names[row], targets[row]
            if local not in self._announced and (target or silent):
                self._announced.add(local)
                if target not in self._present_ns and target not in self._outside:
                    code = self._arrival(target, stamp_ns)
                    if code is not None:
                        log.add(code, tracks, row)
                if not target:
                    self._unheard.add(local)
            if target and target not in self._outside:
                self._present_ns.setdefault(target, stamp_ns)
        self._announced.intersection_update(names)
        self._unheard.intersection_update(names)

    def left(self, tracks: LocalTracks, row: int, log: EventLog) -> None:
        """Note that a local track has left the image (E4), if the fusion node does not know it."""
        known = int(tracks.track_id[row]) in self._present_ns
        if int(tracks.local_id[row]) in self._unheard and not known:
            log.add(EventCode.EXIT, tracks, row)

    def follow(self, feedback: Feedback, blob_box: Floats, stamp_ns: int, log: EventLog) -> None:
        """Note which of the fusion node's targets come into view and which leave it."""
        self._heard_ns = stamp_ns
        foot = self._mapping.image_from_ground(feedback.places(stamp_ns))
        with np.errstate(invalid='ignore'):
            inside = np.asarray(((foot >= 0) & (foot < self._mapping.image_size)).all(axis=1))
        ids = feedback.track_id.tolist()
        self._update_in_view(feedback, ids, stamp_ns)
        for row, (target, is_inside) in enumerate(zip(ids, inside.tolist())):
            is_present = target in self._present_ns
            if is_present:
                self._entering_ns.pop(target, None)
            if not is_inside:
                self._outside.add(target)
            if is_present and is_inside:
                self._present_ns[target] = stamp_ns
                self._outside.discard(target)
            elif is_present:
                self._leave(target, feedback.position[row], stamp_ns, log)
            elif is_inside and self._is_seen(foot[row], blob_box):
                since_ns = self._entering_ns.setdefault(target, stamp_ns)
                if stamp_ns - since_ns >= ENTER_NS:
                    self._arrive(target, feedback.position[row], stamp_ns, log)
            else:
                self._entering_ns.pop(target, None)

    def _update_in_view(self, feedback: Feedback, ids: list[int], stamp_ns: int) -> None:
        """Note where everybody is, who is lost, and whom the fusion node has long known."""
        if self._old is None:
            self._old = set(ids)
            self._new_until_ns = stamp_ns + START_NS
        for target in self._place.keys() - set(ids):
            place = self._place.pop(target)
            if self._present_ns.pop(target, None) is not None:
                self._lost[target] = stamp_ns, place
            self._entering_ns.pop(target, None)
        for target in [one for one, lost in self._lost.items() if self._is_past(lost, stamp_ns)]:
            del self._lost[target]
        self._place.update(zip(ids, feedback.position[:, :2].astype(np.float64)))
        self._outside.intersection_update(ids)
        self._old.intersection_update(ids)

    def _is_past(self, lost: tuple[int, Floats], stamp_ns: int) -> bool:
        return stamp_ns - lost[0] > AGAIN_NS

    def _arrive(
        self, target: int, position: NDArray[np.floating], stamp_ns: int, log: EventLog
    ) -> None:
        code = self._arrival(target, stamp_ns)
        if code is not None:
            log.add_target(code, target, position)
        self._present_ns[target] = stamp_ns
        self._outside.discard(target)

    def _arrival(self, target: int, stamp_ns: int) -> EventCode | None:
        """Return what it is that a target is in view; None: nothing that happened now."""
        if target in self._outside or target in (self._old or ()):
            return EventCode.ENTER
        if target not in self._place or stamp_ns < self._new_until_ns:
            return EventCode.NEW
        place = self._place[target]
        for other, (when_ns, there) in self._lost.items():
            reach = AGAIN_M + AGAIN_M_S * (stamp_ns - when_ns) * 1e-9
            if np.hypot(*(there - place)) < reach:
                del self._lost[other]
                return None
        beside = (
            np.hypot(*(self._place[other] - place)) < BESIDE_M
            for other in self._present_ns
            if other in self._place and other != target
        )
        return None if any(beside) else EventCode.NEW

    def _leave(
        self, target: int, position: NDArray[np.floating], stamp_ns: int, log: EventLog
    ) -> None:
        """Note that a target is out of view; it has left when it was for some time."""
        if stamp_ns - self._present_ns[target] >= GONE_NS:
            del self._present_ns[target]
            log.add_target(EventCode.EXIT, target, position)

    def _is_seen(self, foot: Floats, blob_box: Floats) -> bool:
        """Tell whether there is foreground where a person at a (2,) foot point would be."""
        box = self._sizes.box_of(foot[None], self._extent[None])
        width, height = self._mapping.image_size
        shown = overlap(box, np.array([[0.0, 0.0, width, height]]))[0, 0]
        covered = overlap(box, blob_box).max(initial=0.0)
        return bool(covered > 0 and covered >= COVERED_SHARE * shown)
