"""One camera by silhouettes: image and feedback in, detections and events out."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import ClassCode, Detections, EventCode, Feedback
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.background.scene import Scene
from mctrack_ros.perception.camera_shift.monitor import CameraShift
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.groups import GroupConfig, Groups
from mctrack_ros.perception.feedback.id_assignment import learn_identities
from mctrack_ros.perception.front_end import Arrival, FrontEnd
from mctrack_ros.perception.local_tracks.classification import ClassVotes, looks_like_vehicle
from mctrack_ros.perception.output import CameraOutput, check_image
from mctrack_ros.perception.silhouettes.config import SilhouetteConfig
from mctrack_ros.perception.silhouettes.features import Floats
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes, find_silhouettes
from mctrack_ros.perception.silhouettes.ground_position import Places
from mctrack_ros.perception.silhouettes.objects import at_edge
from mctrack_ros.perception.silhouettes.reference_update.absorption import Absorption
from mctrack_ros.perception.silhouettes.reference_update.holes import patched, without_still_holes
from mctrack_ros.perception.silhouettes.reference_update.stationary_false_foreground import (
    without_stains,
)
from mctrack_ros.perception.silhouettes.reporting import (
    TrackedObjects,
    detections_of,
    note_arrivals,
    note_groups,
    passes,
)
from mctrack_ros.perception.silhouettes.tracker import SilhouetteTracker
from mctrack_ros.tracking.appearance import colour_templates

Image = NDArray[np.uint8]
SPECK_SHARE = 0.3  # of a difference of what is too narrow to be anybody, learned in one look


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
        self._front = FrontEnd(mapping, config.watchdog, mask)
        self._config, self._mapping = config, mapping
        if background is not None:
            check_image(background, mapping.image_size)
            background = self._smoothed(background)
        own = config.background
        self._scene = Scene(own.background(), own.shadows(), mapping, 1.0, mask, background)
        self._nobody = np.zeros(mapping.image_size[::-1], np.uint8)
        self._places = Places(config.places, config.tracker.classes.vehicle_height_m, mapping)
        self._tracker = SilhouetteTracker(config.tracker, self._places.sizes)
        self._rest = Absorption(config.rest)
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
        smooth = self._smoothed(image)
        mask = self._foreground(smooth, stamp_ns)
        if mask is None:
            self._restart()
            return CameraOutput.empty((Detections,), stamp_ns, arrival.shift)
        return self._track(image, smooth, mask, stamp_ns, arrival, feedback)

    def predicted_boxes(self) -> Floats:
        """Return the (n, 4) boxes, px, of the objects, for an overlay."""
        return self._tracker.objects.box.copy()

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, for an overlay."""
        return self._groups.members()

    def _smoothed(self, image: Image) -> Image:
        """Return an image as the background sees it."""
        side = self._config.background.smoothing_px
        return image if side == 1 else cv2.blur(image, (side, side))  # type: ignore[return-value]

    def _foreground(self, smooth: Image, stamp_ns: int) -> Image | None:
        """Return what differs; all else but what may be a shadow is learned."""
        mask, background = self._scene.foreground(smooth, stamp_ns), self._scene.background
        if mask is not None:
            apart, least = background.difference, background.threshold
            kept = np.asarray(cv2.threshold(apart, least, 255, cv2.THRESH_BINARY)[1], np.uint8)
            background.learn(smooth, kept, self._nobody, self._nobody, stamp_ns)
            self._rest.watch(background, smooth, mask, stamp_ns)
        return mask

    def _track(
        self,
        image: Image,
        smooth: Image,
        mask: Image,
        stamp_ns: int,
        arrival: Arrival,
        feedback: Feedback | None,
    ) -> CameraOutput:
        """Match, put on the ground, report."""
        objects, log = self._tracker.objects, EventLog(stamp_ns)
        background = self._scene.background
        silhouettes = self._found(smooth, mask)
        component = self._tracker.step(silhouettes, background, stamp_ns, log)
        note_groups(self._groups, objects, component, stamp_ns, log)
        truncated = at_edge(objects.box, mask.shape, 1.0)
        extent = self._places.extent(objects.box)
        self._classify(extent, (component < 0) & ~truncated, arrival.seconds)
        self._place(arrival.shift)
        if feedback is not None:
            learn_identities(objects, feedback, stamp_ns)
        note_arrivals(objects, log)
        self._pass_on(stamp_ns, log)
        template = colour_templates(image, mask, objects.box.astype(np.int64))
        report = self._config.report
        detections = detections_of(objects, extent, template, truncated, stamp_ns, report)
        resting = self._rest.insert_resting(
            objects, background, smooth, mask, silhouettes.labels, stamp_ns
        )
        objects.keep(~resting)
        return CameraOutput({Detections.TOPIC: detections}, log.rows(), arrival.shift)

    def _classify(self, extent: Floats, is_whole: NDArray[np.bool_], seconds: float) -> None:
        """Vote for the class of the objects, (n,), by how large those are that are seen whole."""
        objects = self._tracker.objects
        large = looks_like_vehicle(extent, self._config.tracker.classes)
        look = np.where(large, ClassCode.VEHICLE, ClassCode.PERSON)
        voting = objects.matched & is_whole
        objects.class_id[:] = self._classes.count(objects.local_id, look, voting, seconds)

    def _found(self, image: Image, mask: Image) -> Silhouettes:
        """Return the silhouettes of an image; a few times a second, mend the background."""
        config, background, still = self._config, self._scene.background, self._rest.still
        grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
        if not self._rest.looked:
            return find_silhouettes(mask, grey, config.components)
        mask = without_still_holes(
            mask, grey, image, still, background, config.components, config.holes
        )
        found = find_silhouettes(mask, grey, config.components)
        if config.components.learn_specks:
            _learn_specks(image, np.where(found.labels == 0, mask, np.uint8(0)), background)
        found = patched(found, image, background, config.holes)
        objects, sizes = self._tracker.objects, self._places.sizes
        return without_stains(found, still, objects, sizes, image, background, config.stains)

    def _place(self, shift: CameraShift) -> None:
        """Look up where on the ground the objects of this image are."""
        objects = self._tracker.objects
        rows = np.flatnonzero(objects.matched)
        vehicle = objects.class_id[rows] == ClassCode.VEHICLE
        position, covariance = self._places.locate(objects.box[rows], vehicle, shift.noise_px)
        objects.mean[rows, :2] = position
        objects.covariance[rows, :2, :2] = covariance

    def _pass_on(self, stamp_ns: int, log: EventLog) -> None:
        """Note pedestrians that have been tracked coherently for long enough by now (E6)."""
        objects = self._tracker.objects
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
            self._scene.begin_anew()

    def _restart(self) -> None:
        """Forget all objects and what was inserted; ids go on."""
        self._tracker.restart()
        self._rest.restart()
        self._groups.restart()
        self._passed = set()


def _learn_specks(image: Image, specks: Image, background: Background) -> None:
    """Let the background follow an image where a mask is not zero."""
    assert background.model is not None
    learned = cv2.addWeighted(background.model, 1 - SPECK_SHARE, image, SPECK_SHARE, 0.0)
    cv2.copyTo(learned, specks, background.model)
