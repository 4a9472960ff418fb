"""The camera's own tracker: blobs and feedback in, detections and events out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Detections, Events, Feedback
from mctrack_ros.perception.blob_split.measurements import (
    LEAST_OWN_SHARE,
    LEAST_VISIBLE,
    Observations,
)
from mctrack_ros.perception.blob_split.single_blobs import NEW
from mctrack_ros.perception.blobs.extraction import Blobs
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.to_detections import confirmed_tracks, reported_persons
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.group_detections import merged_detections
from mctrack_ros.perception.events.view_events import ViewEvents
from mctrack_ros.perception.feedback.id_assignment import learn_identities
from mctrack_ros.perception.geometry.ground_extent import depth_covariance
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.association import match
from mctrack_ros.perception.local_tracks.deletion import lost_tracks
from mctrack_ros.perception.local_tracks.initiate_from_feedback import begin_hidden, hidden_members
from mctrack_ros.perception.local_tracks.observer import Observer
from mctrack_ros.perception.local_tracks.table import ROUND, LocalTracks, Prediction
from mctrack_ros.perception.local_tracks.update import LearningRates, learn
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

    Attributes
    ----------
    tracks : LocalTracks
        As they are after the last image.
    predicted_box : (n, 4) float64 array
        Where they were expected in it, px, before it was looked at.

    """

    def __init__(
        self, config: EventTrackerConfig, mapping: GroundMapping, sizes: SizeTable
    ) -> None:
        filtering, blobs, groups = config.filter, config.blobs, config.groups
        self._config = config.tracker
        self._matching = config.matching
        self._mapping, self._sizes = mapping, sizes
        self._observer = Observer(mapping, sizes, blobs, filtering)
        self.tracks = LocalTracks(filtering, mapping, sizes)
        usual = np.array([blobs.person_width_m, blobs.person_height_m])
        come = config.tracker.vehicles
        self._vehicles = Vehicles(config.classes, come, blobs, sizes, mapping)
        self._events = ViewEvents(groups, usual, sizes, mapping)
        self.predicted_box: NDArray[np.float64] = np.zeros((0, 4))
        self._last_ns: int | None = None

    def restart(self) -> None:
        """Forget all tracks; ids go on."""
        self.tracks.clear()
        self.predicted_box = np.zeros((0, 4))
        self._events.restart()
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
            along each axis; the camera's own tracks lie in one image and do not care.

        """
        log = EventLog(stamp_ns)
        blobs = self._vehicles.whole(blobs, feedback, stamp_ns)  # pieces of one are one
        predicted = self._predict(stamp_ns, log)  # local tracks to the image
        seen = self._associate(blobs, frame, predicted)  # blobs split among those expected
        sure = confirmed_tracks(seen, self.tracks, stamp_ns)  # who is in view
        # who touches whom, who merged and who split
        part = self._events.group(sure, blobs.box, frame, feedback, stamp_ns, log)
        self._update(seen, predicted, blobs, stamp_ns)  # filters, colours, sizes
        seen = self._start(seen, blobs, stamp_ns)  # tracks of blobs that nobody explains
        seen = self._classify(seen, blobs, predicted.seconds, stamp_ns)  # people, vehicles
        self._identify(blobs, part, feedback, stamp_ns, log)  # fusion's ids; who came (E1, E2)
        return self._report(seen, part, blobs, stamp_ns, shift_px), log.rows()

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, of the members that have local tracks."""
        local_id = self._events.in_view.local_id
        ids = [local_id[rows] for rows in self._events.groups()]
        return [tuple(each[each > 0].tolist()) for each in ids]

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

    def _associate(self, blobs: Blobs, frame: Frame, predicted: Prediction) -> Observations:
        """Tell which blob is whose, and who is in the blobs that several share."""
        cells = np.rint(blobs.box / frame.scale).astype(int)
        template = colour_templates(frame.image, frame.mask, cells, frame.balance)
        blob_of = match(self.tracks, predicted, blobs, template, self._matching)
        height_m = self._vehicles.heights(blobs, blob_of, self.tracks)
        return self._observer.observe(
            blob_of, self.tracks, predicted, blobs, template, frame, height_m
        )

    def _classify(
        self, seen: Observations, blobs: Blobs, seconds: float, stamp_ns: int
    ) -> Observations:
        """Separate vehicles from people, confirm; return those visible enough to be reported."""
        tracks = self.tracks
        self._vehicles.classify(tracks, seen, blobs, seconds)
        tracks.confirmed |= stamp_ns - tracks.first_ns >= round(self._config.confirm_s * 1e9)
        return seen.select((seen.visible >= LEAST_VISIBLE) & (seen.own_share >= LEAST_OWN_SHARE))

    def _identify(
        self, blobs: Blobs, part: Ints, feedback: Feedback | None, stamp_ns: int, log: EventLog
    ) -> None:
        """Learn global ids, begin members that only fusion knows; note who came (E1, E2)."""
        tracks, in_view = self.tracks, self._events.in_view
        if feedback is not None:
            learn_identities(tracks, feedback, stamp_ns)
            rows = hidden_members(in_view, part, tracks.track_id, blobs)
            begin_hidden(tracks, in_view, rows, feedback, stamp_ns)
        self._events.appearance.announce(tracks, feedback, blobs.box, stamp_ns, log)

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
            self._events.appearance.left(tracks, row, log)
        kept = ~(left | lost)
        tracks.keep(kept)
        return predicted.select(kept)

    def _update(
        self, seen: Observations, predicted: Prediction, blobs: Blobs, stamp_ns: int
    ) -> None:
        """Correct the tracks with what is seen of them (E6); learn from who is alone."""
        tracks, seconds = self.tracks, predicted.seconds
        pace = LearningRates(
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

    def _report(
        self, seen: Observations, part: Ints, blobs: Blobs, stamp_ns: int, shift_px: float
    ) -> Detections:
        """Write one row for everybody, and one for each group with hidden members."""
        tracks = self.tracks
        noise = seen.noise + shift_px**2 * ROUND if shift_px else seen.noise
        confirm_s = max(self._config.confirm_s, 1e-9)
        shown = reported_persons(seen, tracks, blobs, self._sizes, stamp_ns, confirm_s)
        covariance = self._mapping.ground_covariance(seen.position, noise)
        if seen.depth.any():
            covariance = covariance + depth_covariance(seen.depth)
        class_id = tracks.class_id[seen.track]
        persons = Detections.build(stamp_ns, covariance=covariance, class_id=class_id, **shown)
        groups = merged_detections(self._events.in_view, part, persons)
        return Detections.joined(stamp_ns, [persons, groups]) if len(groups) else persons
