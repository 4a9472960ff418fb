"""Likelihoods on grids from coarse to fine."""

import cv2
import numpy as np

from mctrack_ros.interfaces import NO_EDGE
from mctrack_ros.perception.likelihood_grid.contours import outlines
from mctrack_ros.perception.likelihood_grid.edges import EdgeBackground, Edges, gradient_of
from mctrack_ros.perception.likelihood_grid.oriented_distance import OrientedDistance
from mctrack_ros.perception.likelihood_grid.templates import (
    Grid,
    TemplateHierarchy,
    _parents,
)

GRID = Grid(np.array([-2.0, -1.5]), np.array([2.0, 1.5]), 40)
SIZE = (360, 288)


def edges_around(mapping, places, height=1.75, radius=0.2):
    """Return the edges that people who are cylinders would have."""
    width, rows = SIZE
    found = {}
    contours, normals = outlines(mapping, np.reshape(places, (-1, 2)), height, radius, 'cylinder')
    for contour, normal in zip(contours * 0.5, normals):
        for (x, y), angle in zip(contour, normal):
            if 0 <= x < width and 0 <= y < rows:
                found[int(y) * width + int(x)] = round(angle * 12 / np.pi) % 12
    pixel = np.array(sorted(found), np.int64)
    return Edges(pixel, np.array([found[each] for each in pixel.tolist()], np.uint8))


def templates(mapping):
    return TemplateHierarchy(mapping, SIZE, GRID, 1.75, 0.4, 'cylinder')


def test_cells_are_told_row_by_row():
    centres = GRID.centres()
    assert centres.shape == (1600, 2)
    np.testing.assert_allclose(centres[0], [-1.95, -1.4625])
    np.testing.assert_allclose(centres[1] - centres[0], [0.1, 0])
    np.testing.assert_allclose(centres[40] - centres[0], [0, 0.075])
    np.testing.assert_allclose(GRID.centres(2)[0], (centres[0] + centres[41]) / 2)


def test_a_cell_lies_in_its_parent():
    parent = GRID.centres(2)[_parents(40)]
    assert (np.abs(parent - GRID.centres()) < [0.06, 0.04]).all()


def test_the_likeliest_cell_is_where_a_person_stands(mapping):
    transform, hierarchy = OrientedDistance(SIZE), templates(mapping)
    for cell in (410, 825, 1190):
        place = GRID.centres()[cell]
        found = hierarchy.log_likelihood(transform.transform(edges_around(mapping, [place])))
        best = GRID.centres()[int(np.nanargmax(found))]
        assert np.linalg.norm(best - place) < 0.11
        assert np.nanmax(found) > -0.5
        assert np.nanmin(found) == NO_EDGE


def test_without_edges_nobody_is_likely_anywhere(mapping):
    hierarchy = templates(mapping)
    found = hierarchy.log_likelihood(OrientedDistance(SIZE).transform(edges_around(mapping, [])))
    assert (found[hierarchy.is_seen] == NO_EDGE).all()
    assert np.isnan(found[~hierarchy.is_seen]).all()


def test_where_a_coarse_cell_is_unlikely_its_likelihood_is_inherited(mapping):
    place = GRID.centres()[825]
    edges = edges_around(mapping, [place])
    found = templates(mapping).log_likelihood(OrientedDistance(SIZE).transform(edges))
    blocks = found.reshape(10, 4, 10, 4).swapaxes(1, 2).reshape(100, 16)
    same = (blocks == blocks[:, :1]).all(axis=1)
    assert 40 < same.sum() < 100


def test_half_of_a_person_at_the_edge_of_the_image_is_judged_by_that_half(mapping):
    grid = Grid(np.array([-6.0, -6.0]), np.array([6.0, 6.0]), 40)
    hierarchy = TemplateHierarchy(mapping, SIZE, grid, 1.75, 0.4, 'cylinder')
    assert 0 < hierarchy.is_seen.sum() < 1600
    contour, _ = outlines(mapping, grid.centres(), 1.75, 0.2, 'cylinder')
    with np.errstate(invalid='ignore'):
        share = ((contour >= 0) & (contour < mapping.image_size)).all(axis=2).mean(axis=1)
    np.testing.assert_array_equal(hierarchy.is_seen, share >= 0.5)


def test_the_same_calibration_shares_its_outlines_and_another_does_not(mapping):
    one, same = templates(mapping), templates(mapping)
    other = templates(mapping.moved((0.1, 0.0)))
    assert one._levels is same._levels
    assert one._levels is not other._levels


def test_drawn_people_are_found_as_well(mapping):
    place = np.array([0.2, 0.1])
    foot, head = (mapping.image_from_ground(place[None], level)[0] * 0.5 for level in (0, 1.75))
    image = np.full((SIZE[1], SIZE[0], 3), 100, np.uint8)
    half = float(mapping.width_px(place[None], 0.4)[0]) / 4
    low, high = (round(head[0] - half), round(head[1])), (round(head[0] + half), round(foot[1]))
    cv2.rectangle(image, low, high, (220, 220, 220), -1)
    background = EdgeBackground()
    background.learn(gradient_of(np.full_like(image, 100)), images=1)
    edges = background.foreground(gradient_of(image))
    found = templates(mapping).log_likelihood(OrientedDistance(SIZE).transform(edges))
    assert np.linalg.norm(GRID.centres()[int(np.nanargmax(found))] - place) < 0.3
