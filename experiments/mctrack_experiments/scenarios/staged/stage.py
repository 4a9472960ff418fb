"""People who walk before cameras on a ground plane, and what each camera detects of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.synthetic_cameras import CAMERA_HEIGHT_M, FOCAL_PX
from mctrack_experiments.bench.fusion.toolkit import Scene

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Rectangle = tuple[float, float, float, float]

TICK_S = 0.04
DETECTED = 0.92
"""Probability that a camera detects whom it sees, in one image."""
FOOT_PX = 3.0
"""Standard deviation of a foot point in the image, px."""
BIAS_M = 0.1
"""Standard deviation, along each axis, of what a camera's calibration is off by, m."""
MERGE_LATERAL_M, MERGE_RADIAL_M = 0.45, 4.0
"""Two are one detection who are so near across and along the line of sight, m."""
CLUTTER_DENSITY = 1e-4
"""False detections per image, 1/m²."""
NOBODY = -1
"""What is detected there is nobody."""


@dataclass(frozen=True, slots=True)
class View:
    """
    A camera.

    Attributes
    ----------
    position : (float, float)
        Where it stands, m.
    field : (float, float, float, float)
        What it sees of the ground: x and y from, x and y to, m.

    """

    position: tuple[float, float]
    field: Rectangle


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """
    Who walks where, before whom.

    Attributes
    ----------
    paths : (ticks, people, 2) array
        Where everybody is, m.
    kit : (people,) int array
        Who is dressed alike.
    views : sequence of View
        The cameras.
    hidden : (ticks, people, cameras) bool array
        Whom a camera does not see though he is in its field.
    personal : float
        Share of somebody's colours that are his own and not his kit's.
    bias_m : float
        Standard deviation of what calibrations are off by along each axis, m.
    error_m : float
        Standard deviation of what every detection is off by besides, along each axis, m.

    """

    paths: Floats
    kit: Indices
    views: Sequence[View]
    hidden: Mask
    personal: float
    bias_m: float = BIAS_M
    error_m: float = 0.0


@dataclass(frozen=True, slots=True)
class StagedScenario:
    """What `SyntheticCameras` asks of a scenario of the benchmark."""

    truth: Floats
    cameras: int
    tick_s: float = TICK_S


def within(place: Floats, field: Rectangle) -> Mask:
    """Return which of (..., 2) places are in a rectangle."""
    low, high = np.array(field[:2]), np.array(field[2:])
    return np.asarray(((place >= low) & (place <= high)).all(axis=-1))


def hidden_in(paths: Floats, places: Sequence[Rectangle], cameras: int) -> Mask:
    """Return who is hidden, (ticks, people, cameras), if all cameras are blind in some places."""
    blind = np.zeros(paths.shape[:2], bool)
    for place in places:
        blind |= within(paths, place)
    return np.repeat(blind[:, :, None], cameras, axis=2)


def scene_of(stage: Stage, rng: np.random.Generator) -> Scene:
    """
    Let every camera detect those whom it sees, tick by tick.

    The scene has one more target, the last one, who is nowhere.
    """
    cameras = len(stage.views)
    bias = rng.normal(0.0, stage.bias_m, (cameras, 2))
    rows: list[tuple[Floats, Floats, Indices, Indices]] = []
    for tick, places in enumerate(stage.paths):
        for index, view in enumerate(stage.views):
            shown = within(places, view.field) & ~stage.hidden[tick, :, index]
            place, *rest = _detected(places, shown, view, rng)
            if stage.error_m > 0:
                place = place + rng.normal(0.0, stage.error_m, place.shape)
            rows.append((place + bias[index], *rest))
    position, covariance, target, other = (np.concatenate(each) for each in zip(*rows))
    fields = {
        'pointer': np.concatenate([[0], np.cumsum([len(row[0]) for row in rows])]),
        'detection_position': position,
        'detection_covariance': covariance,
        'detection_target': target,
        'detection_other_target': other,
        'camera_position': np.array([view.position for view in stage.views]),
    }
    background = np.full_like(stage.paths[:, :1], np.inf)  # who lends his colours to clutter
    return Scene(StagedScenario(np.concatenate([stage.paths, background], 1), cameras), fields)


def _detected(
    places: Floats, shown: Mask, view: View, rng: np.random.Generator
) -> tuple[Floats, Floats, Indices, Indices]:
    """Return positions, covariances, who caused them, and who else, of an image."""
    found = np.flatnonzero(shown & (rng.random(len(places)) < DETECTED))
    target, other, shift = merged(places, found, np.array(view.position))
    low, high = np.array(view.field[:2]), np.array(view.field[2:])
    clutter = rng.uniform(low, high, (rng.poisson(CLUTTER_DENSITY * (high - low).prod()), 2))
    exact = np.concatenate([places[target] + shift, clutter])
    nobody = np.full(len(clutter), NOBODY)
    covariance = foot_covariance(exact, np.array(view.position))
    noise = np.linalg.cholesky(covariance) @ rng.normal(size=(len(exact), 2, 1))
    return (
        exact + noise[:, :, 0],
        covariance,
        np.concatenate([target, nobody]),
        np.concatenate([other, nobody]),
    )


def foot_covariance(place: Floats, camera: Floats) -> Floats:
    """
    Return the (n, 2, 2) covariances of foot points at (n, 2) places, m².

    Of a pixel's share across the line of sight, and of what a row is on the ground along it.
    """
    offset = place - camera
    distance = np.linalg.norm(offset, axis=1)
    along = offset / distance[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    radial = FOOT_PX * distance**2 / (FOCAL_PX * CAMERA_HEIGHT_M)
    lateral = FOOT_PX * distance / FOCAL_PX
    return np.asarray(
        np.einsum('n,ni,nj->nij', radial**2, along, along)
        + np.einsum('n,ni,nj->nij', lateral**2, across, across)
    )


def merged(places: Floats, found: Indices, camera: Floats) -> tuple[Indices, Indices, Floats]:
    """
    Return who is detected, who is one detection with him, -1: nobody, and his shift, (k, 2) m.

    The nearest stands for those behind him, moved across the line of sight to the middle of all.
    """
    offset = places[found] - camera
    distance = np.linalg.norm(offset, axis=1)
    target, other, shift = [], [], []
    free = np.ones(len(found), bool)
    for one in np.argsort(distance).tolist():
        if free[one]:
            along = offset[one] / distance[one]
            across = np.array([-along[1], along[0]])
            gap = offset - offset[one]
            aside, behind = gap @ across, gap @ along
            joins = free & (np.abs(aside) < MERGE_LATERAL_M) & (np.abs(behind) < MERGE_RADIAL_M)
            free &= ~joins
            target.append(found[one])
            shift.append(aside[joins].mean() * across)
            joins[one] = False
            other.append(found[joins.argmax()] if joins.any() else NOBODY)
    return np.array(target, int), np.array(other, int), np.array(shift).reshape(-1, 2)
