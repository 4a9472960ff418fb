"""The set of people that explains masks, against the energy as it is defined."""

import itertools

import cv2
import numpy as np
import pytest

from masks import AREA, MAPPINGS, SHAPE, mask_of
from mctrack_ros.fusion.occupancy.config import PeopleConfig
from mctrack_ros.fusion.occupancy.scene import LEAST_DISTANCE_M, REACH_M, Scene
from mctrack_ros.fusion.occupancy.solver import SMALLEST_UNION, Places, solve
from mctrack_ros.fusion.views import Views
from mctrack_ros.ground.coverage.coverage import area_from

COST = 0.05
NAMES = tuple(MAPPINGS)


def energy(people, masks, boxes, prior, used):
    """Return the energy of a set of cells, pixel by pixel."""
    total = len(people) * COST - sum(prior[cell] for cell in people)
    for mask, own, counts in zip(masks, boxes, used):
        if not counts:
            continue
        union = np.zeros(mask.shape, bool)
        for cell in people:
            left, top, right, bottom = own[cell]
            union[top:bottom, left:right] = True
        total += ((mask > 0) ^ union).sum() / (union.sum() + SMALLEST_UNION)
    return total


def are_apart(people, position):
    """Tell whether no two are nearer than people can be."""
    pairs = itertools.combinations(position[people], 2)
    return all(((one - other) ** 2).sum() >= LEAST_DISTANCE_M**2 for one, other in pairs)


def neighbours(people, position):
    """Yield every set that one addition, removal or move makes, people apart."""
    yield from (one for one in changed(people, position) if are_apart(one, position))


def changed(people, position):
    """Yield every set that one addition, removal or move makes."""
    cells = range(len(position))
    for index, person in enumerate(people):
        others = people[:index] + people[index + 1 :]
        yield others
        reached = np.linalg.norm(position - position[person], axis=1) <= REACH_M
        yield from ([*others, cell] for cell in np.flatnonzero(reached))
    yield from ([*people, cell] for cell in cells)


def boxed(boxes, position):
    """Return the places of boxes that are covered wholly."""
    whole = np.full(boxes.shape[:2], -1, np.int32)
    none = np.empty((0, 2), np.int16)
    return Places(position, boxes, whole, none, REACH_M, LEAST_DISTANCE_M)


def scene(cell=0.4, names=NAMES):
    views = Views(MAPPINGS, area_from(AREA))
    return Scene(views, names, PeopleConfig(cell=cell))


def everything(names=NAMES):
    return np.ones(len(names), bool)


def solved(people, cell=0.15, names=NAMES):
    """Return what is found of people at places, (n, 2) m, and the scene."""
    where = scene(cell, names)
    masks = tuple(mask_of(MAPPINGS[name], np.reshape(people, (-1, 2))) for name in names)
    prior = np.zeros(len(where.position))
    return solve(masks, where.places(len(names) * (SHAPE,)), prior, everything(names), COST), where


@pytest.mark.parametrize('seed', range(8))
def test_no_single_change_of_the_people_explains_the_masks_better(seed):
    rng = np.random.default_rng(seed)
    where = scene()
    places = where.places(len(NAMES) * (SHAPE,))
    boxes = places.boxes
    there = where.position[rng.choice(len(where.position), rng.integers(0, 5), replace=False)]
    masks = []
    for name in NAMES:
        mask = mask_of(MAPPINGS[name], there)
        mask[rng.random(SHAPE) < 0.02] ^= 255
        masks.append(mask)
    prior = np.where(rng.random(len(where.position)) < 0.1, 0.02, 0.0)
    used = everything()
    used[rng.integers(len(NAMES))] = seed % 2
    found = solve(tuple(masks), places, prior, used, COST)
    people = found.cell.tolist()
    lowest = energy(people, masks, boxes, prior, used)
    best = min(
        energy(one, masks, boxes, prior, used) for one in neighbours(people, where.position)
    )
    assert lowest <= best + 1e-9
    for index, gain in enumerate(found.gain) if len(people) == 1 else ():
        without = people[:index] + people[index + 1 :]
        assert gain == pytest.approx(energy(without, masks, boxes, prior, used) - lowest)


def test_the_best_set_of_all_is_found_in_a_tiny_scene():
    boxes = np.zeros((2, 6, 4), np.int16)
    for cell in range(6):
        boxes[0, cell] = 10 * cell, 5, 10 * cell + 14, 35
        boxes[1, cell] = 9 * (5 - cell), 2, 9 * (5 - cell) + 12, 30
    masks = tuple(np.zeros((40, 70), np.uint8) for _ in range(2))
    for mask, own in zip(masks, boxes):
        for left, top, right, bottom in own[[1, 4]]:
            mask[top + 2 : bottom, left:right] = 255
    position = np.column_stack([np.arange(6.0), np.zeros(6)])
    prior, used = np.zeros(6), np.ones(2, bool)
    found = solve(masks, boxed(boxes, position), prior, used, COST)
    every = [each for size in range(5) for each in itertools.combinations(range(6), size)]
    best = min(every, key=lambda people: energy(people, masks, boxes, prior, used))
    assert sorted(found.cell.tolist()) == list(best) == [1, 4]


@pytest.mark.parametrize('count', [1, 2, 4])
def test_people_are_found_where_they_stand(count):
    people = np.array([[0.3, 0.2], [-1.2, 0.9], [1.4, -1.1], [-0.8, -1.5]])[:count]
    found, _ = solved(people)
    gaps = np.linalg.norm(found.mean[:, None] - people, axis=2)
    assert gaps.shape == (count, count)
    assert gaps.min(axis=0).max() < 0.15


def two_in_a_file():
    """Return boxes of two cells: the second wholly behind the first in one camera of two."""
    boxes = np.zeros((2, 2, 4), np.int16)
    boxes[0] = [(10, 5, 30, 45), (14, 10, 26, 40)]
    boxes[1] = [(5, 5, 25, 45), (40, 5, 60, 45)]
    masks = tuple(np.zeros((50, 70), np.uint8) for _ in range(2))
    for mask, own in zip(masks, boxes):
        for left, top, right, bottom in own:
            mask[top:bottom, left:right] = 255
    return boxes, masks, np.array([[0.0, 0.0], [5.0, 0.0]])


def test_who_stands_behind_somebody_is_neither_credited_nor_blamed():
    boxes, masks, position = two_in_a_file()
    prior, both = np.zeros(2), np.ones(2, bool)
    found = solve(masks, boxed(boxes, position), prior, both, COST)
    hidden = found.cell.tolist().index(1)
    assert sorted(found.cell.tolist()) == [0, 1]
    assert np.isnan(found.support[hidden, 0])
    assert found.support[hidden, 1] == 1.0
    alone = np.array([False, True])
    gain = energy([0], masks, boxes, prior, alone) - energy([0, 1], masks, boxes, prior, alone)
    assert found.gain[hidden] == pytest.approx(gain)
    masks[1][:, 35:] = 0  # where the other camera does not show him, nothing speaks for him
    assert solve(masks, boxed(boxes, position), prior, both, COST).cell.tolist() == [0]


def test_a_prior_tips_a_tie_and_makes_nobody():
    boxes = np.tile(np.array([10, 5, 30, 45], np.int16), (1, 2, 1))
    mask = np.zeros((50, 40), np.uint8)
    position, used = np.array([[0.0, 0.0], [5.0, 0.0]]), np.ones(1, bool)
    prior = np.array([0.0, 0.02])
    assert len(solve((mask,), boxed(boxes, position), prior, used, COST).cell) == 0
    mask[5:45, 10:30] = 255
    for prior in (np.array([0.0, 0.02]), np.array([0.02, 0.0])):
        found = solve((mask,), boxed(boxes, position), prior, used, COST)
        assert found.cell.tolist() == [prior.argmax()]


def test_a_place_is_uncertain_along_the_line_of_sight_unless_another_camera_crosses_it():
    alone, _ = solved([[0.0, 0.0]], names=('north',))
    crossed, _ = solved([[0.0, 0.0]], names=('east', 'north'))
    (xx, xy), (_, yy) = alone.covariance[0]
    assert yy > 2 * xx
    assert abs(xy) < 0.1 * yy
    assert yy > 2 * np.linalg.eigvalsh(crossed.covariance[0])[-1]


def test_nobody_is_found_without_foreground_cameras_or_cells():
    assert len(solved(np.zeros((0, 2)))[0].cell) == 0
    boxes, masks, position = two_in_a_file()
    prior = np.zeros(2)
    assert len(solve(masks, boxed(boxes, position), prior, np.zeros(2, bool), COST).cell) == 0
    none = tuple(np.zeros((0, 0), np.uint8) for _ in range(2))
    nowhere = np.zeros_like(boxes)
    assert len(solve(none, boxed(nowhere, position), prior, np.ones(2, bool), COST).cell) == 0


def test_masks_of_different_sizes_count_alike():
    boxes, masks, position = two_in_a_file()
    prior, used = np.zeros(2), np.ones(2, bool)
    padded = (np.pad(masks[0], ((0, 30), (0, 9))), masks[1])
    for one, other in zip(
        *(solve(m, boxed(boxes, position), prior, used, COST) for m in (masks, padded))
    ):
        np.testing.assert_array_equal(one, other)


def test_who_is_wide_in_a_mask_has_nobody_beside_him():
    where = scene(0.15)
    masks = []
    for name in NAMES:
        mask = mask_of(MAPPINGS[name], np.array([[0.0, 0.0]]))
        masks.append(cv2.dilate(mask, np.ones((1, 3), np.uint8)))
    prior = np.zeros(len(where.position))
    found = solve(tuple(masks), where.places(len(NAMES) * (SHAPE,)), prior, everything(), COST)
    assert len(found.cell) == 1
