"""One camera by silhouettes: image and feedback in, detections and events out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import ClassCode, Detections, EventCode, Feedback
from mctrack_ros.perception.camera_shift.monitor import CameraShift
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.groups import GroupConfig, Groups
from mctrack_ros.perception.feedback.id_assignment import learn_identities
from mctrack_ros.perception.front_end import Arrival, FrontEnd
from mctrack_ros.perception.local_tracks.classification import ClassVotes, looks_like_vehicle
from mctrack_ros.perception.output import CameraOutput
from mctrack_ros.perception.silhouettes.config import SilhouetteConfig
from mctrack_ros.perception.silhouettes.features import Floats
from mctrack_ros.perception.silhouettes.ground_position import Places
from mctrack_ros.perception.silhouettes.objects import at_edge
from mctrack_ros.perception.silhouettes.reporting import (
    TrackedObjects,
    detections_of,
    note_arrivals,
    note_groups,
    passes,
)
from mctrack_ros.perception.silhouettes.segmentation import Segmentation, Subtracted
from mctrack_ros.perception.silhouettes.tracker import SilhouetteTracker
from mctrack_ros.tracking.appearance import colour_templates

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]


class SilhouettePipeline:
    """
    The tracker of the silhouettes paper as a camera's own (local) tracker.

    Parameters
    ----------
    config : SilhouetteConfig
        Parameters.
    mapping : GroundMapping
        Of the camera; fixes the size of its images.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.

    Raises
    ------
    ValueError
        If the mask or the background has another size than the mapping's images.

    """

    def __init__(
        self,
        config: SilhouetteConfig,
        mapping: GroundMapping,
        mask: Image | None = None,
        background: Image | None = None,
    ) -> None:
        self._front = FrontEnd(mapping, config.camera_shift, mask)
        self._config = config
        self._segmentation = Segmentation(config, mapping, mask, background)
        self._places = Places(
            config.ground_position, config.tracker.classes.vehicle_height_m, mapping
        )
        self._tracker = SilhouetteTracker(config.tracker, self._places.sizes)
        self._classes = ClassVotes()
        self._groups = Groups(GroupConfig(part_s=config.report.part_s))
        self._passed: set[int] = set()

    @property
    def objects(self) -> TrackedObjects:
        """The objects after the last image."""
        objects = self._tracker.objects
        passed = [key in self._passed for key in objects.local_id.tolist()]
        return TrackedObjects(
            objects.local_id.copy(),
            objects.box.copy(),
            objects.class_id.copy(),
            objects.established.copy(),
            objects.matched.copy(),
            np.array(passed, np.bool_),
        )

    def step(self, image: Image, stamp_ns: int, feedback: Feedback | None) -> CameraOutput:
        """
        Process one image.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image of the mapping's size. One that is black or white counts as none.
        stamp_ns : int
            Its capture time, ns. A gap or a step back of more than a second restarts tracking,
            unless the camera is as slow as that; local ids go on.
        feedback : Feedback or None
            The fusion node's, `feedback_delay` old; see `FeedbackBuffer`.

        Raises
        ------
        BackwardStampError
            If the stamp is at or up to a second before the last one; nothing is changed.
        ValueError
            If the image has another size or type; nothing is changed.

        """
        arrival = self._front.take(image, stamp_ns)
        if arrival is None:
            return CameraOutput.empty((Detections,), stamp_ns, self._front.shift)
        self._begin_anew(arrival)
        foreground = self._segmentation.foreground(image, stamp_ns)
        if foreground is None:
            self._restart()
            return CameraOutput.empty((Detections,), stamp_ns, arrival.shift)
        return self._track(image, foreground, stamp_ns, arrival, feedback)

    def predicted_boxes(self) -> Floats:
        """Return the (n, 4) boxes, px, of the objects, for an overlay."""
        return self._tracker.objects.box.copy()

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, for an overlay."""
        return self._groups.members()

    def _track(
        self,
        image: Image,
        foreground: Subtracted,
        stamp_ns: int,
        arrival: Arrival,
        feedback: Feedback | None,
    ) -> CameraOutput:
        """Match, put on the ground, report."""
        objects, log, segmentation = self._tracker.objects, EventLog(stamp_ns), self._segmentation
        silhouettes = segmentation.silhouettes(foreground, objects, self._places.sizes)
        component = self._tracker.step(silhouettes, segmentation.background, stamp_ns, log)
        note_groups(self._groups, objects, component, stamp_ns, log)
        extent, truncated = self._locate(component < 0, foreground.mask.shape, arrival)
        if feedback is not None:
            learn_identities(objects, feedback, stamp_ns)
        self._note_progress(stamp_ns, log)
        template = colour_templates(image, foreground.mask, objects.box.astype(np.int64))
        report = self._config.report
        detections = detections_of(objects, extent, template, truncated, stamp_ns, report)
        objects.keep(~segmentation.insert_resting(objects, foreground, silhouettes, stamp_ns))
        return CameraOutput({Detections.TOPIC: detections}, log.rows(), arrival.shift)

    def _locate(
        self, is_alone: Mask, size: tuple[int, ...], arrival: Arrival
    ) -> tuple[Floats, Mask]:
        """
        Look up how large the objects of this image are and where on the ground.

        Returns
        -------
        extent : (n, 2) array
            Their widths and heights, m.
        truncated : (n,) bool array
            Which touch the image's edge.

        """
        box = self._tracker.objects.box
        truncated, extent = at_edge(box, size, 1.0), self._places.extent(box)
        self._classify(extent, is_alone & ~truncated, arrival.seconds)
        self._place(arrival.shift)
        return extent, truncated

    def _classify(self, extent: Floats, is_whole: Mask, seconds: float) -> None:
        """Vote for the class of the objects, (n,), by how large those are that are seen whole."""
        objects = self._tracker.objects
        large = looks_like_vehicle(extent, self._config.tracker.classes)
        likely = np.where(large, ClassCode.VEHICLE, ClassCode.PERSON)
        voting = objects.matched & is_whole
        objects.class_id[:] = self._classes.count(objects.local_id, likely, voting, seconds)

    def _place(self, shift: CameraShift) -> None:
        """Look up where on the ground the objects of this image are."""
        objects = self._tracker.objects
        rows = np.flatnonzero(objects.matched)
        vehicle = objects.class_id[rows] == ClassCode.VEHICLE
        position, covariance = self._places.locate(objects.box[rows], vehicle, shift.noise_px)
        objects.mean[rows, :2] = position
        objects.covariance[rows, :2, :2] = covariance

    def _note_progress(self, stamp_ns: int, log: EventLog) -> None:
        """Note arrivals (E1, E2), and pedestrians tracked coherently for long enough (E6)."""
        objects = self._tracker.objects
        note_arrivals(objects, log)
        self._passed.intersection_update(objects.local_id.tolist())
        for row in np.flatnonzero(passes(objects, stamp_ns, self._config.report)).tolist():
            if int(objects.local_id[row]) not in self._passed:
                self._passed.add(int(objects.local_id[row]))
                log.add(EventCode.STABLE, objects, row)

    def _begin_anew(self, arrival: Arrival) -> None:
        """Begin anew where time has jumped."""
        if arrival.jumped:
            self._restart()
        if arrival.stepped_back:
            self._segmentation.begin_anew()

    def _restart(self) -> None:
        """Forget all objects and what was inserted; ids go on."""
        self._tracker.restart()
        self._segmentation.restart()
        self._groups.restart()
        self._passed = set()
