"""A detector's boxes on the ground: where a person stands, from the whole of the box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import ClassCode, Detections

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

ITERATIONS = 20
CONVERGED_M = 0.01
HIDDEN_SIGMA = 1e6
"""Standard deviation of an edge that says nothing, px."""
EDGE_PX = 4.0
"""A box that comes so near to the image's edge is cut off by it, px."""


COVERED_SHARE = 0.3
"""Share of a box's lower edge behind a lower box from which its feet are covered."""


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


USUAL_BODY = BodyModel()


def boxes_to_detections(
    boxes: ArrayLike,
    score: ArrayLike,
    mapping: GroundMapping,
    stamp_ns: int,
    body: BodyModel = USUAL_BODY,
    class_id: ArrayLike | None = None,
    local_id: ArrayLike | None = None,
) -> Detections:
    """
    Put the boxes of one image on the ground.

    People stand where an upright body fits the box best; of anything else the middle of the lower
    edge counts. The covariances hold what is assumed of the boxes' edges and what the calibration
    says of itself.

    Parameters
    ----------
    boxes : (n, 4) array_like
        Left, top, width, height, px, in the image as the camera sends it.
    score : (n,) array_like
        Confidence, 0 to 1.
    mapping : GroundMapping
        Of the camera, of any kind.
    stamp_ns : int
        When the image was taken.
    body : BodyModel
        What is assumed.
    class_id : (n,) array_like, optional
        A `ClassCode` each; unless given, all are people.
    local_id : (n,) array_like, optional
        The detector's own tracks, from 1; 0 or not given: none.

    Returns
    -------
    Detections
        Boxes that cannot be put on the ground are left out.

    Raises
    ------
    ValueError
        If a box has no size, a score is beyond 0 to 1, or a number is not finite.

    """
    boxes, score = _rows(boxes, 4), np.asarray(score, np.float64).reshape(-1)
    if not (np.isfinite(boxes).all() and (boxes[:, 2:] > 0).all()):
        raise ValueError('a box is not finite, or its width or height is not above 0')
    _check_score(score)
    kind = _filled(class_id, len(boxes), ClassCode.PERSON)
    width, height = mapping.image_size
    hidden_feet = boxes[:, 1] + boxes[:, 3] > height - EDGE_PX
    hidden_head = boxes[:, 1] < EDGE_PX
    beside = (boxes[:, 0] < EDGE_PX) | (boxes[:, 0] + boxes[:, 2] > width - EDGE_PX)
    place, covariance = upright_fit(boxes, mapping, body, hidden_feet, hidden_head)
    covariance = covariance[:, :2, :2] + mapping.calibration_covariance(place[:, :2])
    other = kind != ClassCode.PERSON
    middle = boxes[other, :2] + boxes[other, 2:] * [0.5, 1.0]
    noise = (body.edge_sigma * boxes[other, 3])[:, None, None] ** 2 * np.eye(2)
    place[other, :2], covariance[other] = mapping.locate(middle, noise)
    return _known(
        stamp_ns,
        place[:, :2],
        covariance,
        box=boxes,
        score=score,
        truncated=hidden_feet | hidden_head | beside,
        class_id=kind,
        local_id=_filled(local_id, len(boxes), 0),
    )


def positions_to_detections(
    position: ArrayLike,
    score: ArrayLike,
    mapping: GroundMapping,
    stamp_ns: int,
    sigma: ArrayLike | None = None,
    body: BodyModel = USUAL_BODY,
    class_id: ArrayLike | None = None,
    local_id: ArrayLike | None = None,
) -> Detections:
    """
    Take places on the ground for what a camera detected in one image.

    Parameters
    ----------
    position : (n, 2) array_like
        On the ground, m.
    score, mapping, stamp_ns, body, class_id, local_id
        As of `boxes_to_detections`.
    sigma : (n,) array_like, optional
        Standard deviation along each axis, m. Where it is not given or NaN, places are as certain
        as the lower edge of a person's box there would make them.

    Returns
    -------
    Detections
        Places that the camera cannot see, of which nobody says how certain they are, are left out.

    Raises
    ------
    ValueError
        If a number is not finite or a score is beyond 0 to 1.

    """
    place, score = _rows(position, 2), np.asarray(score, np.float64).reshape(-1)
    if not np.isfinite(place).all():
        raise ValueError('a position is not finite')
    _check_score(score)
    noise_px = body.edge_sigma * np.abs(mapping.height_px(place, body.height))
    covariance = mapping.ground_covariance(place, noise_px[:, None, None] ** 2 * np.eye(2))
    if sigma is not None:
        reported = np.asarray(sigma, np.float64).reshape(-1)
        known = np.isfinite(reported)
        covariance[known] = reported[known, None, None] ** 2 * np.eye(2)
    return _known(
        stamp_ns,
        place,
        covariance,
        score=score,
        class_id=_filled(class_id, len(place), ClassCode.PERSON),
        local_id=_filled(local_id, len(place), 0),
    )


def _known(stamp_ns: int, place: Floats, covariance: Floats, **columns: ArrayLike) -> Detections:
    """Return detections of those whose place and covariance are known."""
    rows = Detections.build(
        stamp_ns,
        position=np.column_stack([place, np.zeros(len(place))]),
        covariance=covariance,
        **columns,
    )
    certain = np.column_stack([place, covariance.reshape(-1, 4)])
    known: Mask = np.all(np.isfinite(certain), axis=1)
    return rows.select(known)


def _rows(values: ArrayLike, width: int) -> Floats:
    array = np.asarray(values, np.float64)
    if array.size and (array.ndim != 2 or array.shape[1] != width):
        raise ValueError(f'rows have shape {array.shape}, expected (n, {width})')
    return array.reshape(-1, width)


def _check_score(score: Floats) -> None:
    if not ((score >= 0) & (score <= 1)).all():
        raise ValueError('a score is not within 0 to 1')


def _filled(values: ArrayLike | None, count: int, usual: int) -> NDArray[np.int64]:
    return np.full(count, usual) if values is None else np.asarray(values, np.int64).reshape(-1)


def upright_fit(
    boxes: Floats,
    mapping: GroundMapping,
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
    mapping : GroundMapping
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
    place = _first_guess(boxes, mapping, body, measured, weight)
    prior = np.diag([0.0, 0.0, body.height_sigma**-2])
    for _ in range(ITERATIONS):
        edges, slope = _edges_and_slope(place, mapping, body)
        residual = measured - edges
        information = np.einsum('nki,nk,nkj->nij', slope, weight, slope) + prior
        gradient = np.einsum('nki,nk,nk->ni', slope, weight, residual)
        gradient[:, 2] += (body.height - place[:, 2]) / body.height_sigma**2
        solvable = np.isfinite(information).all(axis=(1, 2)) & np.isfinite(gradient).all(axis=1)
        information[~solvable] = np.eye(3)
        covariance = np.linalg.inv(information)
        step = (covariance @ gradient[..., None])[..., 0]
        place = np.where(solvable[:, None], place + np.clip(step, -1, 1), np.nan)
        if not (np.abs(step[solvable]) > CONVERGED_M).any():
            break
    place[(np.abs(step) > CONVERGED_M).any(axis=1)] = np.nan
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
    boxes: Floats, mapping: GroundMapping, body: BodyModel, measured: Floats, weight: Floats
) -> Floats:
    """Begin below the lower edge, or where the ray through the head is a body's height up."""
    foot = mapping.ground_from_image(measured[:, :2])
    camera = mapping.camera_position
    head = np.full_like(foot, np.nan)
    if camera[2] > body.height:
        head = mapping.ground_from_image(measured[:, [0, 2]])
        head += (camera[:2] - head) * (body.height / camera[2])
    both = [np.column_stack([each, np.full(len(boxes), body.height)]) for each in (foot, head)]
    cost = [
        np.sum(weight * (measured - _edges(each, mapping, body)) ** 2, axis=1) for each in both
    ]
    is_nearer = np.nan_to_num(cost[1], nan=np.inf) < np.nan_to_num(cost[0], nan=np.inf)
    return np.where(is_nearer[:, None], both[1], both[0])


def _edges(place: Floats, mapping: GroundMapping, body: BodyModel) -> Floats:
    away = place[:, :2] - mapping.camera_position[:2]
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), body.reach)
    on_ground = np.concatenate([place[:, :2], place[:, :2] - body.reach * away])
    foot, toes = np.split(mapping.image_from_ground(on_ground), 2)
    head = mapping.image_from_ground(place[:, :2], place[:, 2])
    return np.column_stack([(foot[:, 0] + head[:, 0]) / 2, toes[:, 1], head[:, 1]])


def _edges_and_slope(
    place: Floats, mapping: GroundMapping, body: BodyModel, step: float = 1e-4
) -> tuple[Floats, Floats]:
    offsets = step * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
    around = (place + offsets[:, None]).reshape(-1, 3)
    edges = _edges(around, mapping, body).reshape(7, len(place), 3)
    return edges[0], np.moveaxis(edges[1:4] - edges[4:], 0, 2) / (2 * step)
