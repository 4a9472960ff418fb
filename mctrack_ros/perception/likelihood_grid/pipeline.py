"""One camera of the likelihood-grid paper: image in, log-likelihoods on the ground out."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import GroundMapping
from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.interfaces import (
    Detections,
    Events,
    Feedback,
    Foreground,
    Likelihood,
    Message,
)
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.background.objects import marked, objects_in
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.camera_shift.monitor import ShiftState
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.groups import GroupConfig
from mctrack_ros.perception.events.view_events import ViewEvents
from mctrack_ros.perception.feedback.persons_in_view import NO_TRACKS
from mctrack_ros.perception.foreground import Reduction
from mctrack_ros.perception.front_end import FrontEnd
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.likelihood_grid.config import GridConfig, LikelihoodCameraConfig
from mctrack_ros.perception.likelihood_grid.edges import EdgeBackground, gradient_of
from mctrack_ros.perception.likelihood_grid.in_view import targets_in_view
from mctrack_ros.perception.likelihood_grid.oriented_distance import OrientedDistance
from mctrack_ros.perception.likelihood_grid.templates import LEVELS, Grid, TemplateHierarchy
from mctrack_ros.perception.output import CameraOutput, check_image
from mctrack_ros.tracking.appearance import balance_of

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

MESSAGES = (Detections, Likelihood, Foreground)
"""Message types published for each image."""
PERSON_PX = 80.0
"""Images are reduced by a whole factor as long as people stay so high, px: the tolerances of edges
are so about the same share of a person everywhere."""


class LikelihoodCamera:
    """
    Matches edges with the outlines of people on a grid (likelihood-grid paper, section 4).

    Parameters
    ----------
    config : LikelihoodCameraConfig
        Parameters.
    mapping : GroundMapping
        Of the camera; fixes the size of its images.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.

    Raises
    ------
    ConfigError
        If the grid's area or its number of cells cannot be used.
    ValueError
        If the mask or the background has another size than the mapping's images.

    """

    def __init__(
        self,
        config: LikelihoodCameraConfig,
        mapping: GroundMapping,
        mask: Image | None = None,
        background: Image | None = None,
    ) -> None:
        self._config, self._mapping = config, mapping
        self._front = FrontEnd(mapping, config.camera_shift, mask)
        self._factor = _factor(mapping, config.grid.person_height)
        self._mask = None if mask is None else self.reduced(mask)
        grid = grid_of(config.grid)
        place = grid.centres()
        self._position = np.column_stack([place, np.zeros(len(place))]).astype(np.float32)
        width, height = mapping.image_size
        size = width // self._factor, height // self._factor
        self._person = config.grid.person_height, config.grid.person_width
        self._templates = TemplateHierarchy(mapping, size, grid, *self._person, config.grid.shape)
        self._distance = OrientedDistance(size)
        self._edges = EdgeBackground()
        self._background = Background(config.background) if config.foreground else None
        extent = np.array(self._person[::-1])
        self._events = ViewEvents(GroupConfig(), extent, SizeTable(mapping), mapping)
        self._reduction = Reduction(mapping, float(self._factor))
        self._given: Image | None = None
        if background is not None:
            check_image(background, mapping.image_size)
            self._given = self.reduced(background)
        self._seen = Detections.build(0)
        self._forget()

    def step(self, image: Image, stamp_ns: int, feedback: Feedback | None) -> CameraOutput:
        """
        Process one image.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image of the mapping's size. One that is black or white counts as none.
        stamp_ns : int
            Its capture time, ns. A step back of more than a second lets the background be learned
            anew.
        feedback : Feedback or None
            The targets whose events are told and whose colours are measured, and which the
            background does not learn. The likelihoods do not depend on it.

        Raises
        ------
        BackwardStampError
            If the stamp is at or up to a second before the last one; nothing is changed.
        ValueError
            If the image has another size or type; nothing is changed.

        """
        arrival = self._front.take(image, stamp_ns)
        if arrival is None:
            return CameraOutput.empty(MESSAGES, stamp_ns, self._front.shift)
        if arrival.stepped_back:
            self._forget()
        small = self.reduced(image)
        likelihood = self._likelihood(small, stamp_ns)
        frame = self._frame(small, stamp_ns)
        foreground, events = self._foreground(frame, stamp_ns, feedback)
        if arrival.shift.state is ShiftState.MOVED:
            return CameraOutput.empty(MESSAGES, stamp_ns, arrival.shift)
        messages: tuple[Message, ...] = (self._seen, likelihood, foreground)
        by_topic = {message.TOPIC: message for message in messages}
        return CameraOutput(by_topic, events, arrival.shift, self._is_learned)

    @property
    def _is_learned(self) -> bool:
        """Whether all backgrounds are known."""
        background = self._background
        return self._edges.is_learned and (background is None or background.model is not None)

    def predicted_boxes(self) -> Floats:
        """Return the (n, 4) boxes, px, where fusion predicts targets, for an overlay."""
        return self._seen.box.astype(np.float64)

    def groups(self) -> list[tuple[int, ...]]:
        """Return none."""
        return []

    def _likelihood(self, small: Image, stamp_ns: int) -> Likelihood:
        """Return the log-likelihood of every cell; of none while the background is learned."""
        gradient = gradient_of(small)
        if not self._edges.is_learned:
            self._edges.learn(gradient)
            return Likelihood.build(stamp_ns)
        edges = self._edges.foreground(gradient)
        if self._mask is not None:
            edges = edges.within(self._mask)
        distance = self._distance.transform(edges)
        value = self._templates.log_likelihood(distance)
        return Likelihood(stamp_ns, self._position, value)

    def _foreground(
        self, frame: Frame | None, stamp_ns: int, feedback: Feedback | None
    ) -> tuple[Foreground, Events]:
        """Return the reduced mask and what happened; learn the background where nobody is."""
        self._seen = Detections.build(stamp_ns)
        if self._background is None or frame is None:
            self._events.restart()
            return Foreground.build(stamp_ns), Events.build(stamp_ns)
        if feedback is not None:
            self._seen = targets_in_view(feedback, stamp_ns, frame, self._mapping, self._person)
        events = self._happened(frame, stamp_ns, feedback)
        people = marked(self._seen.box / self._factor, frame.mask.shape)
        self._background.learn(frame.image, frame.objects, people, people, stamp_ns)
        return self._reduction.foreground(frame.objects, stamp_ns), events

    def _happened(self, frame: Frame, stamp_ns: int, feedback: Feedback | None) -> Events:
        """Return what happened to the targets in view."""
        _, _, stats, _ = cv2.connectedComponentsWithStats(frame.objects)
        blob_box = np.asarray(stats[1:, :4] * frame.scale, np.float64)
        log, measured = EventLog(stamp_ns), self._seen.template.any(axis=1)
        tracked = self._seen.track_id[measured].astype(np.int64)
        self._events.group(NO_TRACKS, blob_box, frame, feedback, stamp_ns, log, tracked)
        if feedback is not None:
            self._events.appearance.follow(feedback, blob_box, stamp_ns, log)
        return log.rows()

    def _frame(self, small: Image, stamp_ns: int) -> Frame | None:
        """Return an image with its foreground; None: its background is learned, or not wanted."""
        if self._background is None:
            return None
        found, background = self._background.apply(small, stamp_ns), self._background.model
        if found is None or background is None:
            return None
        if self._mask is not None:
            found = np.asarray(cv2.bitwise_and(found, self._mask), np.uint8)
        objects = objects_in(small, background, found)
        difference, scale = self._background.difference, float(self._factor)
        balance = balance_of(background)
        return Frame(small, found, objects, objects, background, difference, scale, balance)

    def _forget(self) -> None:
        """Learn the background, or take the one that was given."""
        self._edges.restart()
        self._events.restart()
        if self._background is not None:
            self._background.restart()
        if self._given is not None:
            self._edges.learn(gradient_of(self._given), images=1)
            if self._background is not None:
                self._background.begin(self._given)

    def reduced(self, image: Image) -> Image:
        """Return an image as small as edges are sought in."""
        if self._factor == 1:
            return image
        height, width = image.shape[:2]
        size = (width // self._factor, height // self._factor)
        return cv2.resize(image, size, interpolation=cv2.INTER_AREA)  # type: ignore[return-value]


def grid_of(config: GridConfig) -> Grid:
    """Return the grid that parameters describe; ConfigError: they cannot be used."""
    if not config.area:
        raise ConfigError(
            'likelihood_grid has to know where people are: name the area of the site'
        )
    try:
        low, high = np.reshape(area_from(config.area).bounds, (2, 2))
    except FieldOfViewError as error:
        raise ConfigError(str(error)) from error
    if config.cells % LEVELS[0]:
        raise ConfigError(f'grid.cells is {config.cells}, expected a multiple of {LEVELS[0]}')
    return Grid(low, high, config.cells)


def _factor(mapping: GroundMapping, height_m: float) -> int:
    """Return by how much images are reduced."""
    upright = mapping.height_px(mapping.visible_ground(), height_m)
    usual = float(np.median(upright)) if len(upright) else PERSON_PX
    return max(int(usual / PERSON_PX), 1)
