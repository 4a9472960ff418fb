"""Where a person stands, from the whole of a detector's box and not only its lower edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.experiments.datasets.stored import Floats
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import ClassCode, Detections

Mask = NDArray[np.bool_]

ITERATIONS = 8
HIDDEN_SIGMA = 1e6
"""Standard deviation of an edge that says nothing, px."""
EDGE_PX = 4.0
"""A box that comes so near to the picture's edge is cut off by it, px."""


COVERED_SHARE = 0.3
"""Feet are covered if a lower box hides so much of a box's lower edge."""


@dataclass(frozen=True, slots=True)
class BodyModel:
    """
    What is assumed about people and about the detector.

    Attributes
    ----------
    height, height_sigma : float
        Of people, mean and standard deviation, m.
    reach : float
        How far before the body's axis its lowest point is: half the length of a foot, m.
    edge_sigma : float
        Standard deviation of a box's edges, as a part of its height.
    covered_sigma : float
        The same of the lower edge and the centre where a nearer person covers the feet.

    """

    height: float = 1.68
    height_sigma: float = 0.10
    reach: float = 0.13
    edge_sigma: float = 0.04
    covered_sigma: float = 0.08


def boxes_to_detections(
    boxes: Floats,
    score: Floats,
    mapping: ProjectiveMapping,
    stamp_ns: int,
    body: BodyModel,
) -> Detections:
    """
    Put boxes on the ground.

    Parameters
    ----------
    boxes : (n, 4) array
        Left, top, width, height, px.
    score : (n,) array
        Confidence, 0 to 1.
    mapping : ProjectiveMapping
        Of the camera.
    stamp_ns : int
        When the picture was taken.
    body : BodyModel
        What is assumed.

    Returns
    -------
    Detections
        Boxes that cannot be put on the ground are left out.

    """
    lowest = mapping.image_size[1] - EDGE_PX
    hidden_feet = boxes[:, 1] + boxes[:, 3] > lowest
    hidden_head = boxes[:, 1] < EDGE_PX
    place, covariance = upright_fit(boxes, mapping, body, hidden_feet, hidden_head)
    known = np.isfinite(place).all(axis=1) & np.isfinite(covariance).all(axis=(1, 2))
    return Detections.build(
        stamp_ns,
        position=np.column_stack([place[:, :2], np.zeros(len(place))])[known],
        covariance=covariance[known, :2, :2],
        box=boxes[known],
        score=score[known],
        truncated=(hidden_feet | hidden_head)[known],
        class_id=np.full(int(known.sum()), ClassCode.PERSON),
    )


def upright_fit(
    boxes: Floats,
    mapping: ProjectiveMapping,
    body: BodyModel,
    hidden_feet: Mask,
    hidden_head: Mask,
) -> tuple[Floats, Floats]:
    """
    Fit upright people to boxes by Gauss-Newton steps.

    A box's lower edge is the row of the toes, on the camera's side of the body's axis; its upper
    edge is that of the head; its centre column is the mean of foot and head. The height has a
    normal prior.

    Parameters
    ----------
    boxes : (n, 4) array
        Left, top, width, height, px.
    mapping : ProjectiveMapping
        Of the camera.
    body : BodyModel
        What is assumed.
    hidden_feet, hidden_head : (n,) bool arrays
        Where an edge is not to be trusted.

    Returns
    -------
    place : (n, 3) array
        x, y and height, m; NaN where there is no solution.
    covariance : (n, 3, 3) array
        Theirs, m².

    """
    measured = np.column_stack(
        [boxes[:, 0] + boxes[:, 2] / 2, boxes[:, 1] + boxes[:, 3], boxes[:, 1]]
    )
    sigma = np.repeat(body.edge_sigma * boxes[:, [3]], 3, axis=1)
    sigma[feet_covered(boxes), :2] = body.covered_sigma * boxes[feet_covered(boxes)][:, [3]]
    sigma[hidden_feet, 1] = sigma[hidden_head, 2] = HIDDEN_SIGMA
    weight = 1 / sigma**2
    place = _first_guess(boxes, mapping, body, hidden_head)
    prior = np.diag([0.0, 0.0, body.height_sigma**-2])
    for _ in range(ITERATIONS):
        slope = _slope(place, mapping, body)
        residual = measured - _edges(place, mapping, body)
        information = np.einsum('nki,nk,nkj->nij', slope, weight, slope) + prior
        gradient = np.einsum('nki,nk,nk->ni', slope, weight, residual)
        gradient[:, 2] += (body.height - place[:, 2]) / body.height_sigma**2
        solvable = np.isfinite(information).all(axis=(1, 2)) & np.isfinite(gradient).all(axis=1)
        information[~solvable] = np.eye(3)
        covariance = np.linalg.inv(information)
        step = (covariance @ gradient[..., None])[..., 0]
        place = np.where(solvable[:, None], place + np.clip(step, -1, 1), np.nan)
    return place, covariance


def feet_covered(boxes: Floats) -> Mask:
    """Tell which of the (n, 4) boxes have a good part of their lower edge behind a lower box."""
    left, top, right, bottom = *boxes[:, :2].T, *(boxes[:, :2] + boxes[:, 2:]).T
    overlap = np.minimum(right[:, None], right) - np.maximum(left[:, None], left)
    share = overlap / boxes[:, [2]]
    nearer = (bottom[:, None] < bottom) & (bottom[:, None] > top)
    covered: Mask = (nearer & (share > COVERED_SHARE)).any(axis=1)
    return covered


def _first_guess(
    boxes: Floats, mapping: ProjectiveMapping, body: BodyModel, hidden_head: Mask
) -> Floats:
    """Cut the ray through the head with the plane of people's heads, or the foot's with z = 0."""
    matrix = mapping.image_from_world
    at_head = np.column_stack([matrix[:, :2], matrix[:, 2] * body.height + matrix[:, 3]])
    centre = boxes[:, 0] + boxes[:, 2] / 2
    top = np.column_stack([centre, boxes[:, 1], np.ones(len(boxes))])
    points = top @ np.linalg.inv(at_head).T
    head = points[:, :2] / points[:, 2:]
    foot = mapping.ground_from_image(np.column_stack([centre, boxes[:, 1] + boxes[:, 3]]))
    ground = np.where(hidden_head[:, None], foot, head)
    return np.column_stack([ground, np.full(len(boxes), body.height)])


def _edges(place: Floats, mapping: ProjectiveMapping, body: BodyModel) -> Floats:
    away = place[:, :2] - mapping.camera_position[:2]
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), body.reach)
    foot = mapping.image_from_ground(place[:, :2])
    toes = mapping.image_from_ground(place[:, :2] - body.reach * away)
    head = mapping.image_from_ground(place[:, :2], place[:, 2])
    return np.column_stack([(foot[:, 0] + head[:, 0]) / 2, toes[:, 1], head[:, 1]])


def _slope(
    place: Floats, mapping: ProjectiveMapping, body: BodyModel, step: float = 1e-4
) -> Floats:
    offsets = step * np.concatenate([np.eye(3), -np.eye(3)])
    around = (place + offsets[:, None]).reshape(-1, 3)
    after, before = _edges(around, mapping, body).reshape(2, 3, len(place), 3)
    return np.moveaxis(after - before, 0, 2) / (2 * step)
