"""The camera's own tracker: blobs and feedback in, detections and events out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import MEMBERS, TEMPLATE_SIZE, Detections, EventCode, Events, Feedback
from mctrack_ros.perception.blobs import Blobs
from mctrack_ros.perception.identity import IdentityConfig, learn_identities
from mctrack_ros.perception.local_events import EventLog
from mctrack_ros.perception.local_tracks import FilterConfig, LocalTracks
from mctrack_ros.perception.matching import Matches, MatchingConfig, match
from mctrack_ros.tracking.appearance import colour_template

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class TrackerConfig:
    """Parameters of `LocalTracker`."""

    confirm_s: float = parameter(
        0.2, 'time after which a local track is believed [s]', minimum=0.0
    )
    coast_s: float = parameter(
        0.8, 'time that a local track lives without a detection [s]', minimum=0.0
    )
    hidden_s: float = parameter(
        3.0, 'time that a track stays in a group no larger than one person [s]', minimum=0.0
    )
    template_time_s: float = parameter(
        1.0, 'time constant with which the template follows the colours [s]', minimum=0.0
    )


class LocalTracker:
    """
    Local tracks of one camera through merges and splits (event-tracking paper, section 4.2).

    Parameters
    ----------
    config : TrackerConfig
        Parameters of the tracks' lives.
    filtering : FilterConfig
        Of their filters.
    matching : MatchingConfig
        Of their matching to blobs.
    identity : IdentityConfig
        Of learning global ids.
    mapping : ProjectiveMapping
        Of the camera.

    """

    def __init__(
        self,
        config: TrackerConfig,
        filtering: FilterConfig,
        matching: MatchingConfig,
        identity: IdentityConfig,
        mapping: ProjectiveMapping,
    ) -> None:
        self._config, self._matching, self._identity = config, matching, identity
        self._mapping = mapping
        self.tracks = LocalTracks(filtering, mapping)
        self._next_group = 1
        self._last_ns: int | None = None

    def restart(self) -> None:
        """Forget all tracks; ids go on."""
        self.tracks.clear()
        self._last_ns = None

    def step(
        self,
        blobs: Blobs,
        image: Image,
        mask: Image,
        scale: float,
        stamp_ns: int,
        feedback: Feedback | None,
    ) -> tuple[Detections, Events]:
        """
        Process the blobs of one picture.

        Parameters
        ----------
        blobs : Blobs
            In pixels of the full picture.
        image : (h, w, 3) uint8 array
            The reduced picture.
        mask : (h, w) uint8 array
            Its foreground.
        scale : float
            Pixels of the picture to one of the reduced.
        stamp_ns : int
            Time of the picture, ns.
        feedback : Feedback or None
            The fusion node's.

        """
        tracks, log = self.tracks, EventLog(stamp_ns)
        seconds = 0.0 if self._last_ns is None else (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns
        tracks.predict(seconds)
        self._drop_lost(stamp_ns, log)
        template = _templates(blobs, image, mask, scale)
        matches = match(tracks, blobs, template, self._matching)
        self._update_singles(matches, blobs, template, seconds, stamp_ns, log)
        self._update_groups(matches, blobs, stamp_ns, log)
        started = self._start(matches, blobs, template, stamp_ns)
        self._confirm(stamp_ns)
        if feedback is not None:
            learn_identities(tracks, feedback, stamp_ns, self._identity)
        self._announce(log)
        detections = self._detections(matches, started, blobs, template, stamp_ns)
        return detections, log.rows()

    def _drop_lost(self, stamp_ns: int, log: EventLog) -> None:
        """Drop tracks that left the picture or were not seen for too long (E4)."""
        tracks = self.tracks
        width, height = self._mapping.image_size
        foot = self._mapping.image_from_ground(tracks.mean[:, :2])
        with np.errstate(invalid='ignore'):
            inside = (foot >= 0).all(axis=1) & (foot[:, 0] < width) & (foot[:, 1] < height * 1.1)
        unseen = (stamp_ns - tracks.seen_ns) * 1e-9
        patience = np.where(tracks.confirmed, self._config.coast_s, self._config.confirm_s)
        left = ~inside & (unseen > 0.0)
        for row in np.flatnonzero(left & tracks.confirmed):
            log.add(EventCode.EXIT, tracks, int(row))
        tracks.keep(~left & (unseen <= patience))

    def _update_singles(
        self,
        matches: Matches,
        blobs: Blobs,
        template: Floats,
        seconds: float,
        stamp_ns: int,
        log: EventLog,
    ) -> None:
        """Correct the tracks that have a blob to themselves (E6), note splits (E3)."""
        tracks, rows, column = self.tracks, matches.single_track, matches.single_blob
        for row in rows[tracks.group[rows] > 0]:
            shared = tracks.group == tracks.group[row]
            shared[row] = False
            log.add(EventCode.SPLIT, tracks, int(row), tracks.local_id[shared])
        box = blobs.box[column]
        tracks.update(rows, blobs.foot[column], tracks.foot_noise(box))
        whole = ~blobs.truncated[column]
        tracks.follow_size(rows[whole], box[whole], seconds)
        share = 1 - np.exp(-seconds / max(self._config.template_time_s, 1e-9))
        tracks.template[rows] += share * (template[column] - tracks.template[rows])
        tracks.group[rows] = 0
        tracks.seen_ns[rows] = stamp_ns

    def _update_groups(self, matches: Matches, blobs: Blobs, stamp_ns: int, log: EventLog) -> None:
        """Carry the members of groups by prediction; note merges (E5)."""
        tracks = self.tracks
        for rows in matches.group_tracks:
            known = tracks.group[rows]
            if (known == 0).any():
                number = int(known.max()) or self._next_group
                self._next_group = max(self._next_group, number + 1)
                first = int(rows[known == 0][0])
                log.add(EventCode.MERGE, tracks, first, tracks.local_id[rows[rows != first]])
                tracks.group[rows] = number
            tracks.seen_ns[rows] = stamp_ns

    def _start(self, matches: Matches, blobs: Blobs, template: Floats, stamp_ns: int) -> Ints:
        """Start a track for each blob that none explains."""
        free = matches.free_blob
        noise = self.tracks.foot_noise(blobs.box[free])
        return self.tracks.start(
            blobs.position[free], blobs.box[free], noise, template[free], stamp_ns
        )

    def _confirm(self, stamp_ns: int) -> None:
        tracks = self.tracks
        self._fresh = ~tracks.confirmed & (
            stamp_ns - tracks.first_ns >= round(self._config.confirm_s * 1e9)
        )
        tracks.confirmed |= self._fresh

    def _announce(self, log: EventLog) -> None:
        """Note what was confirmed: known to the fusion node (E2) or new (E1)."""
        for row in np.flatnonzero(self._fresh):
            known = self.tracks.track_id[row] > 0
            log.add(EventCode.ENTER if known else EventCode.NEW, self.tracks, int(row))

    def _detections(
        self, matches: Matches, started: Ints, blobs: Blobs, template: Floats, stamp_ns: int
    ) -> Detections:
        """Write one row a blob."""
        tracks, count = self.tracks, len(blobs)
        owner = np.full(count, -1, np.int64)
        owner[matches.single_blob] = matches.single_track
        owner[matches.free_blob] = started
        member_count = np.ones(count, np.uint8)
        members = np.zeros((count, MEMBERS), np.uint32)
        for blob, rows in zip(matches.group_blob, matches.group_tracks):
            member_count[blob] = len(rows)
            known = tracks.track_id[rows]
            known = known[known > 0][:MEMBERS]
            members[blob, : len(known)] = known
        single = owner >= 0
        age = np.full(count, np.inf)
        age[single] = (stamp_ns - tracks.first_ns[owner[single]]) * 1e-9
        score = np.clip(age / max(self._config.confirm_s, 1e-9), 0.1, 1.0)
        local_id, track_id = np.zeros((2, count), np.int64)
        local_id[single] = tracks.local_id[owner[single]]
        track_id[single] = tracks.track_id[owner[single]]
        noise = tracks.foot_noise(blobs.box)
        noise[:, 0, 0] += np.where(single, 0.0, (blobs.box[:, 2] / 4) ** 2)
        return Detections.build(
            stamp_ns,
            position=np.column_stack([blobs.position, np.zeros(count)]),
            covariance=self._mapping.ground_covariance(blobs.position, noise),
            box=blobs.box,
            area=blobs.area,
            score=score,
            template=template,
            local_id=local_id,
            track_id=track_id,
            members=members,
            member_count=member_count,
            truncated=blobs.truncated,
        )


def _templates(blobs: Blobs, image: Image, mask: Image, scale: float) -> Floats:
    """Return the (n, 48) colours of the blobs' foreground."""
    result = np.zeros((len(blobs), TEMPLATE_SIZE))
    for row, box in enumerate(np.rint(blobs.box / scale).astype(int)):
        left, top, width, height = box
        part = np.s_[top : top + height, left : left + width]
        result[row] = colour_template(image[part], mask[part])
    return result
