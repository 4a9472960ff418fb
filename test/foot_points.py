"""A small tracker of each side, with messages and feedback of its own, that can be registered."""

import multiprocessing
from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from mctrack_ros import fusion, perception
from mctrack_ros.config import parameter, tag
from mctrack_ros.fusion.config import FusionConfig
from mctrack_ros.fusion.trackers import FusionMethod
from mctrack_ros.interfaces import Column, EventCode, Events, Rows, Tracks, TrackStatus
from mctrack_ros.perception.config import CameraConfig
from mctrack_ros.perception.output import CameraOutput
from mctrack_ros.perception.trackers import CameraMethod

NAME = 'feet'


@dataclass(frozen=True, eq=False, slots=True)
class FootPoints(Rows):
    """Where blobs touch the ground; `area` in px²."""

    TOPIC: ClassVar[str] = 'foot_points'
    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': Column('f4', (3,), float('nan')),
        'area': Column('f4'),
    }

    position: NDArray[np.float32]
    area: NDArray[np.float32]


@dataclass(frozen=True, eq=False, slots=True)
class Headcount(Rows):
    """The places of all that are tracked."""

    TOPIC: ClassVar[str] = 'headcount'
    COLUMNS: ClassVar[dict[str, Column]] = {'position': Column('f4', (3,), float('nan'))}

    position: NDArray[np.float32]


@dataclass(frozen=True)
class FeetConfig(CameraConfig):
    local_tracker: str = tag(NAME)
    contrast: int = parameter(50, 'difference from the first image', minimum=1, maximum=255)


class Feet:
    """What differs from the first image stands where it ends below."""

    def __init__(self, config, name, mapping, mask=None, background=None):
        self._config, self._mapping, self._first = config, mapping, background
        self._boxes = np.zeros((0, 4))

    def step(self, image, stamp_ns, feedback):
        self._first = image if self._first is None else self._first
        changed = cv2.absdiff(image, self._first).max(axis=2) > self._config.contrast
        blobs = cv2.connectedComponentsWithStats(changed.astype(np.uint8))[2][1:]
        blobs = blobs[blobs[:, cv2.CC_STAT_AREA] > 50]
        self._boxes = blobs[:, :4].astype(float)
        foot = self._boxes[:, :2] + self._boxes[:, 2:] * [0.5, 1.0]
        place = self._mapping.ground_from_image(foot)
        place = np.column_stack([place, np.zeros(len(place))])
        told = FootPoints.build(stamp_ns, position=place, area=blobs[:, cv2.CC_STAT_AREA])
        known = [] if feedback is None else feedback.position
        events = Events.build(stamp_ns, position=known, event=[EventCode.STABLE] * len(known))
        return CameraOutput({FootPoints.TOPIC: told}, events, perception.CameraShift())

    def predicted_boxes(self):
        return self._boxes

    def groups(self):
        return []


@dataclass(frozen=True)
class NearestConfig(FusionConfig):
    tracker: str = tag(NAME)
    gate: float = parameter(1.0, 'how far a target goes between images [m]', minimum=0.0)


class Nearest:
    """A track is wherever the foot point nearest to it was last."""

    bias = None

    def __init__(self, config, cameras, first_id):
        self._gate, self.next_id = config.gate, first_id
        self._places = {}
        self._stamp_ns = 0

    def step(self, tick, recorder=None):
        self._stamp_ns = tick.stamp_ns
        for message in tick.messages:
            for place in message.rows.position.astype(float):
                gaps = {one: np.hypot(*(at - place)[:2]) for one, at in self._places.items()}
                nearest = min(gaps, key=gaps.get, default=0)
                if not nearest or gaps[nearest] > self._gate:
                    nearest, self.next_id = self.next_id, self.next_id + 1
                self._places[nearest] = place
        status = [TrackStatus.CONFIRMED] * len(self._places)
        columns = {'position': list(self._places.values()), 'track_id': list(self._places)}
        tracks = Tracks.build(tick.stamp_ns, **columns, status=status)
        return fusion.FusionOutput(tracks, Events.build(tick.stamp_ns))

    def feedback(self):
        return Headcount.build(self._stamp_ns, position=list(self._places.values()))


CAMERA_METHOD = CameraMethod(
    FeetConfig, lambda config, given: Feet(config, *given[:4]), (FootPoints,), Headcount
)
FUSION_METHOD = FusionMethod(
    NearestConfig,
    lambda config, cameras, first_id, _: Nearest(config, cameras, first_id),
    (FootPoints,),
    lambda rows: rows,
    lambda rows: 0,
    Headcount,
)


def register(monkeypatch):
    """Add both for the time of a test."""
    monkeypatch.setitem(perception.trackers.TRACKERS, NAME, CAMERA_METHOD)
    monkeypatch.setitem(fusion.trackers.TRACKERS, NAME, FUSION_METHOD)


if multiprocessing.current_process().name != 'MainProcess':  # a worker of such a test
    register(pytest.MonkeyPatch())
