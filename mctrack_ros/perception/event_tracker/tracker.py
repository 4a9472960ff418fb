"""The camera's own tracker: blobs and feedback in, detections and events out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Detections, EventCode, Events, Feedback
from mctrack_ros.perception.blob_split.measurements import (
    LEAST_PROVEN,
    LEAST_VISIBLE,
    Observations,
)
from mctrack_ros.perception.blob_split.single_blobs import NEW
from mctrack_ros.perception.blobs.extraction import Blobs
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.blobs.touching import contacts
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.to_detections import reported_persons, sighted
from mctrack_ros.perception.events.appearance_events import (
    AppearanceEvents,
)
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.group_detections import merged_detections
from mctrack_ros.perception.events.groups import Groups
from mctrack_ros.perception.events.stable_events import StableEvents
from mctrack_ros.perception.feedback.id_assignment import learn_identities
from mctrack_ros.perception.feedback.missed_detections import missed_detections
from mctrack_ros.perception.feedback.persons_in_view import (
    NOBODY,
    PersonList,
    PersonsInView,
    Sighting,
)
from mctrack_ros.perception.geometry.ground_extent import depth_covariance
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.association import match
from mctrack_ros.perception.local_tracks.deletion import lost_tracks
from mctrack_ros.perception.local_tracks.initiate_from_feedback import begin_hidden, hidden_members
from mctrack_ros.perception.local_tracks.observer import Observer
from mctrack_ros.perception.local_tracks.table import ROUND, LocalTracks, Prediction
from mctrack_ros.perception.local_tracks.update import Pace, learn
from mctrack_ros.perception.local_tracks.vehicles import Vehicles
from mctrack_ros.tracking.appearance import colour_templates

Ints = NDArray[np.int64]
SIZE_TIME_S, COLOURS_TIME_S = 0.5, 1.0
"""Time constants with which tracked sizes and colours follow what is seen: a step, and two."""


class LocalTracker:
    """
    Local tracks of one camera through merges and splits (event-tracking paper, section 4.2).

    Parameters
    ----------
    config : EventTrackerConfig
        Parameters.
    mapping : GroundMapping
        Of the camera.
    sizes : SizeTable
        Of the camera.
    ignored : (h, w) uint8 array or None
        0 where the camera does not look.

    Attributes
    ----------
    tracks : LocalTracks
        As they are after the last image.
    predicted_box : (n, 4) float64 array
        Where they were expected in it, px, before it was looked at.

    """

    def __init__(
        self,
        config: EventTrackerConfig,
        mapping: GroundMapping,
        sizes: SizeTable,
        ignored: NDArray[np.uint8] | None,
    ) -> None:
        filtering, blobs, groups = config.filter, config.blobs, config.groups
        self._ignored = ignored
        self._config = config.tracker
        self._matching = config.matching
        self._mapping, self._sizes = mapping, sizes
        self._observer = Observer(mapping, sizes, blobs, filtering)
        self.tracks = LocalTracks(filtering, mapping, sizes)
        usual = np.array([blobs.person_width_m, blobs.person_height_m])
        self._vehicles = Vehicles(config.classes, config.tracker.vehicles, usual)
        self._roll, self._in_view = PersonList(usual, sizes, mapping), NOBODY
        self._groups, self._steadiness = Groups(groups), StableEvents(groups.stable_s)
        self._presence = AppearanceEvents(usual, sizes, mapping)
        self.predicted_box: NDArray[np.float64] = np.zeros((0, 4))
        self._last_ns: int | None = None

    def restart(self) -> None:
        """Forget all tracks; ids go on."""
        self.tracks.clear()
        self.predicted_box = np.zeros((0, 4))
        self._roll.restart()
        self._in_view = NOBODY
        self._groups.restart()
        self._steadiness.restart()
        self._presence.restart()
        self._last_ns = None

    def step(
        self,
        blobs: Blobs,
        frame: Frame,
        stamp_ns: int,
        feedback: Feedback | None,
        shift_px: float = 0.0,
    ) -> tuple[Detections, Events]:
        """
        Process the blobs of one image.

        Parameters
        ----------
        blobs : Blobs
            In pixels of the full image.
        frame : Frame
            With its foreground.
        stamp_ns : int
            Time of the image, ns.
        feedback : Feedback or None
            The fusion node's.
        shift_px : float
            How far the camera has moved, px. What is published is by its square less certain
            along each axis, and nothing is said of who is not seen; the camera's own tracks lie
            in one image and do not care.

        """
        log = EventLog(stamp_ns)
        predicted = self._predict(stamp_ns, log)
        seen = self._associate(blobs, frame, predicted, stamp_ns)
        part = self._group(seen, blobs, frame, feedback, stamp_ns, log)
        self._update(seen, predicted, blobs, stamp_ns)
        seen = self._start(seen, blobs, stamp_ns)
        seen = self._classify(seen, blobs, predicted.seconds)
        self._confirm(stamp_ns)
        if feedback is not None:
            self._identify(blobs, part, feedback, stamp_ns)
        self._presence.announce(self.tracks, feedback, blobs.box, stamp_ns, log)
        detections = self._detections(seen, blobs, stamp_ns, shift_px)
        looks_right = feedback is not None and shift_px == 0.0  # else beside where they stand
        return self._with_groups(detections, part, frame, looks_right), log.rows()

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, of the members that have local tracks."""
        found = []
        for keys in self._groups.members():
            ids = self._in_view.local_id[np.searchsorted(self._in_view.key, keys)]
            found.append(tuple(ids[ids > 0].tolist()))
        return found

    def walked_ids(self) -> Ints:
        """Return the local ids, (k,), of those who walked to where they are."""
        return self.tracks.local_id[self.tracks.walked]

    def _predict(self, stamp_ns: int, log: EventLog) -> Prediction:
        """Predict the tracks to an image; return where they are expected in it."""
        seconds = 0.0 if self._last_ns is None else (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns
        self.tracks.predict(seconds)
        predicted = self._without_lost(self.tracks.prediction(), stamp_ns, log)
        self.predicted_box = predicted.box
        return predicted

    def _associate(
        self, blobs: Blobs, frame: Frame, predicted: Prediction, stamp_ns: int
    ) -> Observations:
        """Tell which blob is whose, and who is in the blobs that several share."""
        cells = np.rint(blobs.box / frame.scale).astype(int)
        template = colour_templates(frame.image, frame.mask, cells, frame.balance)
        blob_of = match(self.tracks, predicted, blobs, template, self._matching)
        height_m = self._vehicles.heights(blobs, blob_of, self.tracks)
        return self._observer.observe(
            blob_of, self.tracks, predicted, blobs, template, frame, height_m, stamp_ns
        )

    def _group(
        self,
        seen: Observations,
        blobs: Blobs,
        frame: Frame,
        feedback: Feedback | None,
        stamp_ns: int,
        log: EventLog,
    ) -> Ints:
        """Tell who is in view and who touches whom; return the part that each one is of."""
        if feedback is not None:
            self._groups.rename(feedback.corrections())
        in_view = self._roll.call(self._sighting(seen, stamp_ns), feedback, stamp_ns)
        part = contacts(in_view.box, blobs.box, frame)
        self._note_groups(in_view, part, stamp_ns, log)
        return part

    def _classify(self, seen: Observations, blobs: Blobs, seconds: float) -> Observations:
        """Separate vehicles from people; return those visible enough to be reported."""
        self._vehicles.classify(self.tracks, seen, blobs, seconds)
        return seen.select((seen.visible >= LEAST_VISIBLE) & (seen.proven >= LEAST_PROVEN))

    def _identify(self, blobs: Blobs, part: Ints, feedback: Feedback, stamp_ns: int) -> None:
        """Learn global ids, and begin tracks of members that only the fusion node knows."""
        tracks, in_view = self.tracks, self._in_view
        learn_identities(tracks, feedback, stamp_ns)
        rows = hidden_members(in_view, part, tracks.track_id, blobs)
        begin_hidden(tracks, in_view, rows, feedback, stamp_ns)

    def _with_groups(
        self, detections: Detections, part: Ints, frame: Frame, looks_right: bool
    ) -> Detections:
        """Add detections of whole groups and, in a sound image, of bare ground."""
        in_view, stamp_ns = self._in_view, detections.stamp_ns
        more = [merged_detections(in_view, part, detections)]
        if looks_right:
            more.append(missed_detections(in_view, part, frame, self._ignored, stamp_ns))
        if not any(map(len, more)):
            return detections
        return Detections.joined(stamp_ns, [detections, *more])

    def _without_lost(self, predicted: Prediction, stamp_ns: int, log: EventLog) -> Prediction:
        """Drop tracks that left the image or were not seen for too long (E4)."""
        tracks = self.tracks
        width, height = self._mapping.image_size
        left, lost = lost_tracks(
            predicted.foot,
            self._sizes.table,
            float(width),
            float(height),
            stamp_ns,
            tracks.seen_ns,
            tracks.clear_ns,
            tracks.confirmed,
            predicted.seconds,
            self._config.coast_s,
            self._config.confirm_s,
            self._config.hidden_s,
        )
        if not (left.any() or lost.any()):
            return predicted
        for row in np.flatnonzero(left).tolist():
            self._presence.left(tracks, row, log)
        kept = ~(left | lost)
        tracks.keep(kept)
        return predicted.select(kept)

    def _note_groups(
        self, in_view: PersonsInView, part: Ints, stamp_ns: int, log: EventLog
    ) -> None:
        """Note who joined a group (E5), who left one (E3), and who is stable (E6)."""
        self._in_view = in_view
        for change in self._groups.step(in_view.key, part, stamp_ns, ~in_view.came):
            code = EventCode.MERGE if change.merged else EventCode.SPLIT
            rows = (
                np.searchsorted(in_view.key, change.part),
                np.searchsorted(in_view.key, change.rest),
            )
            log.add_group(code, in_view, *rows)
        for row in self._steadiness.step(in_view, self._groups.sizes(), part, stamp_ns):
            log.add_group(EventCode.STABLE, in_view, np.array([row]), np.zeros(0, np.int64))

    def _sighting(self, seen: Observations, stamp_ns: int) -> Sighting:
        """Return the confirmed tracks as this image shows them."""
        tracks = self.tracks
        return Sighting(
            *sighted(
                seen, tracks.confirmed, tracks.local_id, tracks.mean, tracks.first_ns, stamp_ns
            )
        )

    def _update(
        self, seen: Observations, predicted: Prediction, blobs: Blobs, stamp_ns: int
    ) -> None:
        """Correct the tracks with what is seen of them (E6); learn from who is alone."""
        tracks, seconds = self.tracks, predicted.seconds
        pace = Pace(
            float(1 - np.exp(-seconds / SIZE_TIME_S)),
            float(1 - np.exp(-seconds / COLOURS_TIME_S)),
        )
        measured = learn(
            seen,
            blobs.truncated,
            stamp_ns,
            self._sizes.table,
            pace,
            tracks.seen_ns,
            tracks.clear_ns,
            tracks.extent,
            tracks.template,
        )
        self._vehicles.stand(tracks, seen, seen.track != NEW, blobs)
        whole = ~(seen.fitted | blobs.truncated[seen.blob]) & (seen.visible == 1.0)
        telling = np.where(whole, measured, NEW)
        tracks.follow_noise(predicted, telling, seen.foot, seen.noise, seconds)
        tracks.update(predicted, measured, seen.foot, seen.noise)

    def _start(self, seen: Observations, blobs: Blobs, stamp_ns: int) -> Observations:
        """Start a track for each person, bicycle or vehicle that has none."""
        new = seen.track == NEW
        if not new.any():
            return seen
        noise = self.tracks.foot_noise(seen.box[new])
        colours = np.where(seen.fitted[new, None], 0.0, seen.template[new])
        track = seen.track.copy()
        near = seen.position[new] - seen.depth[new] / 2
        track[new] = self.tracks.start(near, seen.box[new], noise, colours, stamp_ns)
        seen = seen._replace(track=track)
        self._vehicles.stand(self.tracks, seen, new, blobs)
        return seen

    def _confirm(self, stamp_ns: int) -> None:
        tracks = self.tracks
        tracks.confirmed |= stamp_ns - tracks.first_ns >= round(self._config.confirm_s * 1e9)

    def _detections(
        self, seen: Observations, blobs: Blobs, stamp_ns: int, shift_px: float
    ) -> Detections:
        """Write one row for everybody."""
        tracks = self.tracks
        noise = seen.noise + shift_px**2 * ROUND if shift_px else seen.noise
        shown = reported_persons(
            seen,
            blobs.area,
            blobs.truncated,
            self._sizes.table,
            tracks.first_ns,
            tracks.local_id,
            tracks.track_id,
            tracks.template,
            stamp_ns,
            max(self._config.confirm_s, 1e-9),
        )
        covariance = self._mapping.ground_covariance(seen.position, noise)
        if seen.depth.any():
            covariance = covariance + depth_covariance(seen.depth)
        class_id = tracks.class_id[seen.track]
        return Detections.build(
            stamp_ns, covariance=covariance, class_id=class_id, **shown._asdict()
        )
