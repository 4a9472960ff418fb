"""Vehicles by masks, people by detections."""

import cv2
import numpy as np
import pytest

from drawn_hall import SIZE, projection
from mctrack_ros.fusion import open_fusion
from mctrack_ros.fusion.inputs import OccupancyInput
from mctrack_ros.fusion.occupancy.config import VehicleConfig
from mctrack_ros.fusion.occupancy.solver import solve
from mctrack_ros.fusion.occupancy.vehicle_scene import SIZE_M, TURNS, VehicleScene
from mctrack_ros.fusion.views import Views
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.interfaces import CameraRows, ClassCode, Detections, Foreground, RowsTick

POSITIONS = {'east': (22.0, 0.0, 7.0), 'north': (0.0, 22.0, 7.0), 'west': (-22.0, 3.0, 7.0)}
MAPPINGS = {name: ProjectiveMapping(projection(at), SIZE) for name, at in POSITIONS.items()}
NAMES = tuple(MAPPINGS)
SHAPE = SIZE[::-1]
PERIOD_NS = 80_000_000
COST = 0.05


def views():
    return Views(MAPPINGS, area_from('-7,-7,7,7'))


def corners(mapping, at, turn, size=SIZE_M):
    """Return the (8, 2) px of a car's corners."""
    length, width, height = size
    around = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * [length / 2, width / 2]
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    ground = around @ rotation.T + at
    parts = [mapping.image_from_ground(ground, z) for z in (0.0, height)]
    return np.concatenate(parts)


def mask_of(mapping, cars):
    """Return the mask of cars, each (x, y, turn)."""
    mask = np.zeros(SHAPE, np.uint8)
    for x, y, turn in cars:
        hull = cv2.convexHull(np.rint(corners(mapping, (x, y), turn)).astype(np.int32))
        cv2.fillConvexPoly(mask, hull, 255)
    return mask


def test_the_outlines_are_those_of_cuboids():
    scene = VehicleScene(views(), NAMES)
    places = scene.places(len(NAMES) * (SHAPE,))
    rng = np.random.default_rng(1)
    for camera, mapping in enumerate(MAPPINGS.values()):
        for cell in rng.choice(len(scene.position), 40, replace=False):
            left, top, right, bottom = places.boxes[camera, cell]
            drawn = np.zeros(SHAPE, np.uint8)
            row = places.first[camera, cell]
            for column, (above, below) in enumerate(
                places.outline[row : row + right - left], left
            ):
                drawn[above:below, column] = 1
            turn = cell % TURNS * np.pi / TURNS
            hull = cv2.convexHull(
                np.rint(corners(mapping, scene.position[cell], turn)).astype(int)
            )
            truth = cv2.fillConvexPoly(np.zeros(SHAPE, np.uint8), hull, 1)
            if left < right:
                assert (drawn & truth).sum() > 0.85 * (drawn | truth).sum()
                assert not drawn[:top].any()
                assert not drawn[bottom:].any()
    assert (np.diff(scene.position[:, 1]) >= 0).all()


@pytest.mark.parametrize(
    'cars',
    [
        [],
        [(1.0, 2.0, 0.3)],
        [(-3.0, 1.0, 1.5), (2.0, -2.0, 0.0)],
        [(0.0, 2.0, 0.0), (0.0, -2.0, 0.0)],
    ],
    ids=['none', 'one', 'two', 'side by side'],
)
def test_cars_are_found_where_they_stand(cars):
    scene = VehicleScene(views(), NAMES)
    masks = tuple(mask_of(mapping, cars) for mapping in MAPPINGS.values())
    prior = np.zeros(len(scene.position))
    used = np.ones(len(NAMES), bool)
    found = solve(masks, scene.places(len(NAMES) * (SHAPE,)), prior, used, COST)
    assert len(found.cell) == len(cars)
    for x, y, _ in cars:
        assert np.linalg.norm(found.mean - (x, y), axis=1).min() < 0.5


def detections_of(mapping, people, parts, stamp_ns):
    """Return what a camera says of people at (n, 2) m, and of parts of cars at (k, 2) m."""
    place = np.concatenate([np.reshape(people, (-1, 2)), np.reshape(parts, (-1, 2))])
    foot, head = (mapping.image_from_ground(place, height) for height in (0.0, 1.7))
    wide = mapping.width_px(place, 0.5)
    box = np.column_stack([foot[:, 0] - wide / 2, head[:, 1], wide, foot[:, 1] - head[:, 1]])
    count = len(place)
    return Detections.build(
        stamp_ns,
        position=np.column_stack([place, np.zeros(count)]),
        covariance=np.tile(np.eye(2) * 0.04, (count, 1, 1)),
        box=box,
        score=np.ones(count),
        local_id=np.arange(1, count + 1),
        class_id=np.full(count, ClassCode.PERSON),
    )


def watched(cars, people, parts, count=30):
    """Return the tracks after some ticks, and the tracker."""
    tracker = open_fusion(VehicleConfig(), NAMES, views=views)
    for index in range(count):
        stamp_ns = 10**12 + index * PERIOD_NS
        messages = []
        for name, mapping in MAPPINGS.items():
            mask = Foreground(stamp_ns, mask_of(mapping, cars))
            told = detections_of(mapping, people, parts, stamp_ns)
            messages.append(CameraRows(name, OccupancyInput(told, mask)))
        output = tracker.step(RowsTick.of(messages))
    return output.tracks, tracker


def test_a_car_is_one_vehicle_and_no_person_though_cameras_see_people_in_its_parts():
    tracks, tracker = watched([(1.0, 0.0, 0.4)], [[-3.0, 2.0]], [[2.0, 0.6], [0.2, -0.3]])
    assert sorted(tracks.class_id.tolist()) == [ClassCode.PERSON, ClassCode.VEHICLE]
    order = np.argsort(tracks.class_id)
    np.testing.assert_allclose(tracks.position[order, :2], [[-3, 2], [1, 0]], atol=0.4)
    assert len(set(tracks.track_id.tolist())) == 2
    assert (np.diff(tracks.track_id.astype(int)) > 0).all()
    told = tracker.feedback()
    assert told.track_id.tolist() == tracks.track_id.tolist()
    assert tracker.next_id > tracks.track_id.max()


def test_who_walks_beside_a_car_or_in_front_of_it_is_a_person():
    tracks, _ = watched([(1.0, 0.0, 0.0)], [[1.0, 2.3], [-2.9, 0.0]], np.empty((0, 2)))
    people = tracks.select(tracks.class_id == ClassCode.PERSON)
    assert len(people) == 2
    assert (tracks.class_id == ClassCode.VEHICLE).sum() == 1


def test_without_masks_people_are_tracked_and_cameras_named():
    tracker = open_fusion(VehicleConfig(), NAMES, views=views)
    for index in range(30):
        stamp_ns = 10**12 + index * PERIOD_NS
        output = tracker.step(
            RowsTick.of(
                [
                    CameraRows(
                        name,
                        OccupancyInput(
                            detections_of(mapping, [[1.0, 1.0]], np.empty((0, 2)), stamp_ns),
                            Foreground.build(stamp_ns),
                        ),
                    )
                    for name, mapping in MAPPINGS.items()
                ]
            )
        )
    assert len(output.tracks) == 1
    assert set(output.left_out) == set(NAMES)
