"""The default tracker with `vehicles`: what is as large as a car is one object, and said so."""

import cv2
import numpy as np
import pytest

from mctrack_ros.config import config_from
from mctrack_ros.interfaces import ClassCode, Feedback
from mctrack_ros.perception import EventTracker, EventTrackerConfig
from mctrack_ros.perception.local_tracks.vehicles import bicycles_among, vehicles_among
from sensor_noise import with_noise

GROUND = (60, 120, 60)


def reported(targets, stamp_ns, extent=None):
    """Return feedback of standing targets, two periods old, by id, all of one size."""
    return Feedback.build(
        stamp_ns - 80_000_000,
        position=[[*place, 0.0] for place in targets.values()],
        covariance=np.tile(np.diag([0.02, 0.02, 0.1, 0.1]), (len(targets), 1, 1)),
        track_id=list(targets),
        **({} if extent is None else {'extent': [extent] * len(targets)}),
    )


class Road:
    """Draws cars and people on a noisy ground, so many images a second."""

    def __init__(self, mapping, rate_hz=25.0, **tracker):
        self.mapping, self.rate_hz = mapping, rate_hz
        self.pipeline = EventTracker(
            config_from(EventTrackerConfig, {'tracker': tracker}), mapping
        )
        self.rng = np.random.default_rng(0)
        self.index = 0
        for _ in range(round(1.6 * rate_hz)):
            self.show([])

    def outline(self, place, size):
        """Return where the corners of a box of width, length and height, m, are seen."""
        x, y, z = (np.array(ends) for ends in ((-0.5, 0.5), (-0.5, 0.5), (0.0, 1.0)))
        corner = np.stack(np.meshgrid(x, y, z), axis=-1).reshape(-1, 3) * size
        corner[:, :2] += place
        pixel = self.mapping.image_from_ground(corner[:, :2], corner[:, 2])
        return cv2.convexHull(np.rint(pixel).astype(np.int32))

    def show(self, bodies, targets=None, extent=None):
        """Return what is told of an image; targets are where the fusion node has whom."""
        self.index += 1
        stamp_ns = round(self.index / self.rate_hz * 1e9)
        width, height = self.mapping.image_size
        image = np.full((height, width, 3), GROUND, np.uint8)
        for place, size, colour in bodies:
            cv2.fillConvexPoly(image, self.outline(place, size), colour)
        noisy = with_noise(image, 2, self.rng)
        feedback = reported(targets, stamp_ns, extent) if targets else None
        return self.pipeline.step(noisy, stamp_ns, feedback)


ON_FOOT, BICYCLE, VEHICLE = ClassCode.PERSON, ClassCode.BICYCLE, ClassCode.VEHICLE
CAR, PERSON = (4.2, 1.8, 1.5), (0.5, 0.3, 1.75)


def drive(road, seconds=3.0, speed=4.0, start=-8.0):
    """Return the detections of a car that passes, 10 m from the camera."""
    steps = round(seconds * road.rate_hz)
    place = start + speed * np.arange(steps) / road.rate_hz
    return [road.show([((x, -1.0), CAR, (200, 60, 30))]).detections for x in place], place


@pytest.mark.parametrize('rate_hz', [4.0, 25.0])
def test_a_car_is_one_object_that_stands_in_the_middle_of_its_ground(mapping, rate_hz):
    seen, place = drive(Road(mapping, rate_hz, vehicles=True))
    whole = [
        (detections, x)
        for detections, x in zip(seen, place)
        if len(detections) and not detections.truncated.any()
    ]
    assert len(whole) > rate_hz / 2
    assert {len(detections) for detections, _ in whole} == {1}
    assert len({int(detections.local_id[0]) for detections, _ in whole}) == 1
    late = whole[len(whole) // 2 :]
    assert {int(detections.class_id[0]) for detections, _ in late} == {ClassCode.VEHICLE}
    for detections, x in late:
        assert np.allclose(detections.position[0, :2], (x, -1.0), atol=0.7)
        assert detections.extent[0, 0] == pytest.approx(CAR[0], rel=0.25)
        assert detections.covariance[0, 1, 1] > 0.1


def test_people_who_meet_are_no_vehicle(mapping):
    road = Road(mapping, vehicles=True)
    for step in range(50):
        gap = max(2.5 - 0.06 * step, 0.35)
        people = [((side * gap, 0.0), PERSON, (30, 30, 220)) for side in (-2, -1, 0, 1, 2)]
        detections = road.show(people).detections
    assert ClassCode.VEHICLE not in detections.class_id
    assert len(detections) > 2


def test_who_was_taken_for_a_vehicle_in_a_bunch_is_a_person_at_his_feet_when_it_parts(mapping):
    road = Road(mapping, vehicles=True)
    bunch = [((x, y), PERSON, (30, 30, 220)) for y in (2, 1.4, 0.7, 0) for x in (-0.8, 0, 0.8)]
    between = ((0.0, 0.7), (2.2, 0.3, 1.0), (30, 30, 220))
    known = {
        int(name) for _ in range(10) for name in road.show([*bunch, between]).detections.local_id
    }
    targets = {}
    for step in range(100):
        apart = min(step * 0.06, 3.0)
        place = [(-apart - 0.8, 0.0), (0.0, 0.0), (apart + 0.8, 0.0)]
        if step >= 75:
            targets = dict(enumerate(place, start=7))
        people = [(where, PERSON, (30, 30, 220)) for where in place]
        detections = road.show(people, targets).detections
    assert detections.class_id.tolist() == [ClassCode.PERSON] * 3
    assert known <= set(detections.local_id.tolist())
    assert len(known) == 1
    assert sorted(detections.track_id.tolist()) == [7, 8, 9]


def test_unless_vehicles_come_all_are_people(mapping):
    seen, _ = drive(Road(mapping))
    kinds = {int(kind) for detections in seen for kind in detections.class_id}
    assert kinds == {ClassCode.PERSON}


def test_a_person_keeps_one_track_at_four_images_a_second(mapping):
    road = Road(mapping, 4.0)
    seen = [road.show([((0.25 * step, 0.0), PERSON, (30, 30, 220))]) for step in range(12)]
    ids = {int(name) for output in seen for name in output.detections.local_id}
    assert ids == {1}


def test_a_vehicle_came_as_a_whole_and_people_gathered():
    # one that is known, one that is new, people, a new one still cut off, and a known one
    blob_of = np.array([0, 1, 2, 2, 3, 4, -1])
    kind = np.array([VEHICLE, 0, ON_FOOT, 0, 0, VEHICLE, ON_FOOT])
    lead = np.array([1.0, 0.0, 0.5, 0.0, 0.0, 0.2, 1.0])
    truncated = np.array([False, False, False, True, True])
    look = np.array([VEHICLE, VEHICLE, VEHICLE, VEHICLE, ON_FOOT])
    vehicle = vehicles_among(blob_of, kind, lead, look, truncated)
    assert vehicle.tolist() == [True, True, False, False, True]


def test_a_bicycle_is_one_while_nobody_else_is_believed_to_be_in_its_blob():
    # one that looks so, one that did, with a track just begun, one with somebody else, a person
    # and one that is hidden in something longer
    blob_of = np.array([0, 1, 1, 2, 2, 3, 4, -1])
    kind = np.array([0, BICYCLE, 0, BICYCLE, ON_FOOT, ON_FOOT, BICYCLE, BICYCLE])
    confirmed = np.array([True, True, False, True, True, True, True, True])
    look = np.array([BICYCLE, ON_FOOT, BICYCLE, ON_FOOT, VEHICLE])
    short = np.array([True, True, True, True, False])
    bicycle = bicycles_among(blob_of, kind, confirmed, look, short)
    assert bicycle.tolist() == [True, True, False, False, False]


def test_bicycles_side_by_side_are_no_vehicle():
    # two that are known, one of which it is not sure, and one before a car that is known
    blob_of = np.array([0, 0, 1, 2, 2])
    kind = np.array([BICYCLE, BICYCLE, BICYCLE, BICYCLE, VEHICLE])
    lead = np.array([1.0, 1.0, 0.1, 1.0, 1.0])
    look, truncated = np.full(3, VEHICLE), np.zeros(3, np.bool_)
    vehicle = vehicles_among(blob_of, kind, lead, look, truncated)
    assert vehicle.tolist() == [False, True, True]


@pytest.mark.parametrize('extent', [(3.0, 1.5), (0.5, 1.7), None])
def test_pieces_of_a_car_that_fusion_knows_are_one(mapping, extent):
    """Of a car as green as the ground four dark windows; somebody stands beside."""
    road = Road(mapping, 12.5, vehicles=True)
    windows = [((x, -1.0), (0.4, 1.8, 1.2), (20, 20, 20)) for x in (-1.2, -0.4, 0.4, 1.2)]
    beside = ((4.5, -1.0), PERSON, (200, 60, 30))
    for _ in range(20):
        found = road.show([*windows, beside], {7: (0.0, -1.0)}, extent).detections
    single = found.select(found.member_count == 1)
    known = extent == (3.0, 1.5)
    assert (single.class_id == VEHICLE).tolist().count(True) == known
    assert len(single) == (2 if known else 5)
