"""People on bicycles: wheels that do not bend, legs that go round."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.carpark.rendering.vehicles import rotated
from mctrack_ros.simulation.rendering.bodies import METAL, Cloth, Pose

Floats = NDArray[np.float64]
Point = tuple[float, float, float]

RIDER_M = 1.8
"""All lengths are for a rider of this height."""

_WHEEL_M, _AXLES = 0.34, (-0.53, 0.53)
_SPOKES, _TYRE_M, _TUBE_M = 12, 0.06, 0.05
_CRANK, _CRANK_M = np.array((-0.08, 0.0, 0.28)), 0.17
_SADDLE, _HEAD, _BAR = (-0.24, 0.0, 0.92), (0.36, 0.0, 0.86), (0.34, 0.0, 1.02)
_HIP, _SHOULDER = (-0.22, 0.0, 0.98), (0.10, 0.0, 1.44)
_BEND, _TOE = np.array((0.22, 0.0, 0.10)), np.array((0.16, 0.0, -0.02))
_TREADLE = 0.10
"""How far a foot is from the middle, m."""


def mounted(
    place: Floats, heading: float, stride: float, height: float
) -> tuple[Pose, NDArray[np.int64]]:
    """
    Pose somebody on a bicycle.

    Parameters
    ----------
    place : (2,) array
        The middle of it on the ground, m.
    heading, stride, height : float
        Where it goes, rad; phase of the pedals, rad; height of the rider, m.

    Returns
    -------
    pose : Pose
        Of one, as bars.
    part : (bars,) int64 array
        What each is made of.

    """
    bars = [*_wheels(), *_frame(), *_rider(stride)]
    scale = height / RIDER_M
    ends = np.array([(one, other) for one, other, _, _ in bars]) * scale
    ends[..., :2] = rotated(ends[..., :2], heading) + place
    width = np.array([(wide, wide) for _, _, wide, _ in bars]) * scale
    return Pose(ends[None], width[None]), np.array([part for *_, part in bars], np.int64)


_Bar = tuple[Point, Point, float, int]


def _wheels() -> list[_Bar]:
    """Return both rims."""
    bars: list[_Bar] = []
    for axle in _AXLES:
        angle = np.linspace(0.0, 2 * np.pi, _SPOKES + 1)
        x, z = axle + _WHEEL_M * np.sin(angle), _WHEEL_M * (1 + np.cos(angle))
        rim = [(float(one), 0.0, float(up)) for one, up in zip(x, z)]
        bars += [(one, other, _TYRE_M, METAL) for one, other in pairwise(rim)]
    return bars


def _frame() -> list[_Bar]:
    """Return tubes, fork and handlebar."""
    crank = (float(_CRANK[0]), 0.0, float(_CRANK[2]))
    rear, front = ((axle, 0.0, _WHEEL_M) for axle in _AXLES)
    left, right = ((_BAR[0], side, _BAR[2]) for side in (0.25, -0.25))
    tubes = [
        (crank, _SADDLE), (crank, _HEAD), (_SADDLE, _HEAD), (rear, crank), (rear, _SADDLE),
        (front, _HEAD), (_HEAD, _BAR), (left, right),
    ]  # fmt: skip
    return [(one, other, _TUBE_M, METAL) for one, other in tubes]


def _rider(stride: float) -> list[_Bar]:
    """Return legs on the pedals, trunk, arms on the handlebar, and head."""
    bars: list[_Bar] = []
    for side, phase in ((1.0, stride), (-1.0, stride + np.pi)):
        turned = (_CRANK_M * np.sin(phase), side * _TREADLE, _CRANK_M * np.cos(phase))
        foot, hip = _CRANK + turned, _HIP + np.array((0.0, side * _TREADLE, 0.0))
        knee = (foot + hip) / 2 + _BEND
        grip, shoulder = (_BAR[0], side * 0.22, _BAR[2]), (_SHOULDER[0], side * 0.18, 1.40)
        elbow = (0.24, side * 0.24, 1.16)
        bars += [
            (_point(hip), _point(knee), 0.16, Cloth.SHORTS),
            (_point(knee), _point(foot), 0.11, Cloth.SOCK),
            (_point(foot), _point(foot + _TOE), 0.09, Cloth.SHOE),
            (shoulder, elbow, 0.11, Cloth.SLEEVE),
            (elbow, grip, 0.09, Cloth.SKIN),
        ]
    head = (_SHOULDER[0] + 0.10, 0.0, _SHOULDER[2] + 0.12)
    crown = (head[0] + 0.02, 0.0, head[2] + 0.20)
    return [
        *bars,
        (_HIP, _SHOULDER, 0.34, Cloth.SHIRT),
        (head, crown, 0.19, Cloth.SKIN),
        ((head[0], 0.0, head[2] + 0.14), crown, 0.20, Cloth.HAIR),
    ]


def _point(place: Floats) -> Point:
    return float(place[0]), float(place[1]), float(place[2])
