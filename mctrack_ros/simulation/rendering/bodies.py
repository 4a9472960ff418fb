"""Articulated bodies: joints that swing with the stride, limbs as quadrilaterals."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera

Floats = NDArray[np.float64]

_HIP, _SHOULDER, _ANKLE_M = 0.92, 1.45, 0.09
_STANCE_M = 0.10
_LIMBS = 14
_DRAWN_WIDER_PX = 0.5


class Cloth(IntEnum):
    """What a pixel of a body is made of."""

    NOTHING = 0
    SHOE = 1
    SOCK = 2
    SHORTS = 3
    SHIRT = 4
    SLEEVE = 5
    SKIN = 6
    HAIR = 7


METAL = 8
"""What a pixel of a bicycle is made of."""


@dataclass(frozen=True, eq=False, slots=True)
class Pose:
    """
    Limbs of some people, each a tapered bar between two ends.

    Attributes
    ----------
    ends : (n, limbs, 2, 3) array
        Both ends, m, in the world.
    width : (n, limbs, 2) array
        Widths at the ends, m, as seen from the camera.

    """

    ends: Floats
    width: Floats


CLOTH = np.array(
    [
        *[Cloth.SHOE, Cloth.SHOE, Cloth.SOCK, Cloth.SOCK, Cloth.SHORTS, Cloth.SHORTS],
        *[Cloth.SHORTS, Cloth.SHIRT, Cloth.SLEEVE, Cloth.SLEEVE, Cloth.SKIN, Cloth.SKIN],
        *[Cloth.SKIN, Cloth.HAIR],
    ],
    np.int64,
)
"""What each limb is made of: feet, shins, thighs, hips, trunk, upper arms, forearms, head."""

_WIDTHS = np.array(
    [
        *[(0.09, 0.08)] * 2,
        *[(0.12, 0.09)] * 2,
        *[(0.18, 0.15)] * 2,
        *[(0.36, 0.34), (0.34, 0.44)],
        *[(0.13, 0.11)] * 2,
        *[(0.10, 0.08)] * 2,
        *[(0.19, 0.19), (0.20, 0.19)],
    ]
)
_FLAT = {6: 0.62, 7: 0.58}
"""Hips and trunk are this much narrower from the side."""


def posed(
    position: Floats, heading: Floats, speed: Floats, stride: Floats, height: Floats, eye: Floats
) -> Pose:
    """
    Pose people: the standing foot is at the ground position, the other swings above it.

    Parameters
    ----------
    position : (n, 2) array
        On the ground, m.
    heading, speed, stride, height : (n,) arrays
        Direction faced, rad; m/s; phase of the gait, rad; height of the person, m.
    eye : (3,) array
        Where the camera is, m; widths are those seen from there.

    """
    effort = np.clip(speed / 6.0, 0, 1)
    limbs = (
        _limbs(effort, np.clip(speed / 1.0, 0, 1), stride) * (height / 1.8)[:, None, None, None]
    )
    forward = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    left = np.stack([-forward[:, 1], forward[:, 0]], axis=1)
    ends = np.empty_like(limbs)
    ends[..., :2] = (
        position[:, None, None]
        + limbs[..., :1] * forward[:, None, None]
        + limbs[..., 1:2] * left[:, None, None]
    )
    ends[..., 2] = limbs[..., 2]
    to_eye = eye[:2] - position
    to_eye = to_eye / np.maximum(np.linalg.norm(to_eye, axis=1, keepdims=True), 1e-9)
    sideways = np.abs((to_eye * left).sum(axis=1))
    width = np.repeat(_WIDTHS[None], len(position), axis=0)
    for limb, flat in _FLAT.items():
        width[:, limb] *= (1 - (1 - flat) * sideways)[:, None]
    return Pose(ends, width * (height / 1.8)[:, None, None])


def outlines(pose: Pose, camera: Camera) -> tuple[Floats, NDArray[np.int64]]:
    """
    Project limbs to quadrilaterals.

    Returns
    -------
    corners : (n, limbs, 4, 2) array
        Corners, px.
    order : (n, limbs) int array
        Limbs from far to near.

    """
    pixel = camera.project(pose.ends)
    depth = camera.depth(pose.ends)
    half = pose.width * (camera.focal_px / np.maximum(depth, 1.0)) / 2
    half = np.maximum(half - _DRAWN_WIDER_PX, 0.25)
    along = pixel[:, :, 1] - pixel[:, :, 0]
    length = np.linalg.norm(along, axis=2, keepdims=True)
    along = np.where(length > 1e-6, along / np.maximum(length, 1e-6), [0.0, 1.0])
    across = np.stack([-along[..., 1], along[..., 0]], axis=2)
    first, second = pixel[:, :, 0], pixel[:, :, 1]
    side = [half[:, :, end, None] * across for end in (0, 1)]
    corners = np.stack([first - side[0], first + side[0], second + side[1], second - side[1]], 2)
    return corners, np.argsort(-depth.mean(axis=2), axis=1, kind='stable')


def _limbs(effort: Floats, walks: Floats, stride: Floats) -> Floats:
    """
    Return limb ends of (n,) people of 1.8 m at the origin: (n, limbs, 2, 3) forward, left, up.

    A foot on the ground stays within a hand's breadth of the body's place and the other is in the
    air, so the lowest pixel of the body is the ground position at every speed.
    """
    limbs = np.zeros((len(effort), _LIMBS, 2, 3))
    lean = 0.12 * effort
    bob = 0.02 * walks * np.abs(np.cos(stride))
    hip, shoulder = _HIP - 0.04 * effort - bob, _SHOULDER - 0.05 * effort - bob
    for side, left in ((0, 1.0), (1, -1.0)):
        phase = stride + np.pi * side
        limbs[:, [side, 2 + side, 4 + side]] = _leg(effort, walks, phase, left, hip)
        limbs[:, [8 + side, 10 + side]] = _arm(effort, walks, phase, left, lean, shoulder)
    limbs[:, 6] = _bar(_point(0, 0, hip - 0.06), _point(lean * 0.3, 0, hip + 0.14))
    limbs[:, 7] = _bar(_point(lean * 0.3, 0, hip + 0.1), _point(lean, 0, shoulder + 0.03))
    limbs[:, 12] = _bar(_point(lean, 0, shoulder + 0.06), _point(lean * 1.3, 0, shoulder + 0.28))
    limbs[:, 13] = _bar(
        _point(lean * 1.25, 0, shoulder + 0.25), _point(lean * 1.3, 0, shoulder + 0.34)
    )
    return limbs


def _leg(effort: Floats, walks: Floats, phase: Floats, left: float, hip: Floats) -> Floats:
    """Return foot, shin and thigh: (n, 3, 2, 3)."""
    swing, lift = np.sin(phase), np.maximum(np.cos(phase), 0) * walks
    reach = walks * swing * (0.10 + (0.1 + 0.5 * effort) * lift)
    sideways = left * _STANCE_M * (1 - 0.5 * effort)
    ankle = _point(reach, sideways, _ANKLE_M + lift * (0.08 + 0.3 * effort))
    top = _point(0, left * 0.10, hip)
    bend = _point(0.04 + lift * (0.10 + 0.22 * effort), 0, 0.06 * lift)
    knee = (ankle + top) / 2 + bend
    heel, toe = ankle + _point(-0.06, 0, -0.02), ankle + _point(0.16, 0, -0.02)
    return np.stack([_bar(heel, toe), _bar(knee, ankle), _bar(top, knee)], axis=1)


def _arm(
    effort: Floats, walks: Floats, phase: Floats, left: float, lean: Floats, shoulder: Floats
) -> Floats:
    """Return upper arm and forearm, which swing against the legs: (n, 2, 2, 3)."""
    top = _point(lean, left * 0.2, shoulder - 0.03)
    swung = -np.sin(phase) * walks * (0.12 + 0.18 * effort)
    elbow = top + _point(swung - 0.03, left * 0.06, -0.27 + 0.04 * effort)
    hand = elbow + _point(swung * 0.4 + 0.05 + 0.1 * effort, -left * 0.02, -0.24 + 0.12 * effort)
    return np.stack([_bar(top, elbow), _bar(elbow, hand)], axis=1)


def _bar(first: Floats, second: Floats) -> Floats:
    """Return (n, 2, 3) ends of a limb."""
    return np.stack(np.broadcast_arrays(first, second), axis=1)


def _point(forward: Floats | float, left: Floats | float, up: Floats | float) -> Floats:
    """Return (n, 3) points of three broadcast coordinates."""
    count = max(np.size(forward), np.size(left), np.size(up))
    point = np.empty((count, 3))
    point[:, 0], point[:, 1], point[:, 2] = forward, left, up
    return point
