"""Edges of the scene are taken out, those of people stay."""

import cv2
import numpy as np
import pytest

from mctrack_ros.perception.likelihood_grid.edges import (
    LEARNING_IMAGES,
    ORIENTATIONS,
    EdgeBackground,
    gradient_of,
)

SHAPE = (120, 160, 3)


def scene(rng, light=1.0):
    image = np.full(SHAPE, 120, np.uint8)
    for x in range(10, 160, 25):
        cv2.rectangle(image, (x, 5), (x + 9, 60), (20, 20, 60), -1)
    image = np.clip(image * light, 0, 255)
    return np.clip(image + rng.normal(0, 2, SHAPE), 0, 255).astype(np.uint8)


def learned(rng):
    background = EdgeBackground()
    for _ in range(LEARNING_IMAGES):
        assert not background.is_learned
        background.learn(gradient_of(scene(rng)))
    assert background.is_learned
    return background


def test_edges_of_the_scene_are_taken_out(rng):
    background = learned(rng)
    before = np.count_nonzero(gradient_of(scene(rng)).edges())
    left = background.foreground(gradient_of(scene(rng)))
    assert before > 500
    assert len(left.pixel) < 0.01 * before


@pytest.mark.parametrize('light', [0.7, 1.3])
def test_a_light_step_brings_no_edges(rng, light):
    left = learned(rng).foreground(gradient_of(scene(rng, light)))
    assert len(left.pixel) < 30


def test_edges_of_a_person_stay_and_have_their_direction(rng):
    image = scene(rng)
    cv2.rectangle(image, (70, 70), (90, 110), (230, 230, 230), -1)
    left = learned(rng).foreground(gradient_of(image))
    row, column = np.divmod(left.pixel, SHAPE[1])
    near = (abs(column - 70) <= 2) | (abs(column - 90) <= 2)
    sides = near & (row > 75) & (row < 105)
    assert sides.sum() >= 50
    assert (left.direction[sides] == 0).all()
    tops = (abs(row - 70) <= 2) & (column > 75) & (column < 85)
    assert (left.direction[tops] == ORIENTATIONS // 2).all()
    assert (np.diff(left.pixel) > 0).all()


def test_an_edge_that_crosses_one_of_the_scene_stays(rng):
    image = scene(rng)
    cv2.rectangle(image, (0, 30), (159, 40), (250, 250, 250), -1)
    left = learned(rng).foreground(gradient_of(image))
    row, column = np.divmod(left.pixel, SHAPE[1])
    crossing = (abs(row - 30) <= 2) & (column >= 12) & (column <= 17)
    assert crossing.sum() >= 3


def test_edges_outside_a_mask_do_not_count(rng):
    image = scene(rng)
    cv2.rectangle(image, (70, 70), (90, 110), (230, 230, 230), -1)
    mask = np.zeros(SHAPE[:2], np.uint8)
    mask[:, :80] = 1
    left = learned(rng).foreground(gradient_of(image)).within(mask)
    assert len(left.pixel)
    assert (left.pixel % SHAPE[1] < 80).all()
