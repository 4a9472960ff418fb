"""Input that no sound camera sends: each spoils the messages of one tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import MEMBERS, CameraDetections, Detections

Messages = list[CameraDetections]
Spoiler = Callable[[Messages, int, np.random.Generator], Messages]
"""Takes a tick's messages, how many ticks were spoiled before, and a source of randomness."""

FLOOD = 10_000
MOST_ID = 2**32
SPOT_M = (50.0, 30.0)
NOT_COVARIANCES = np.array(
    [
        [[-1, 0], [0, 1]],
        [[1, 2], [2, 1]],
        [[0, 0], [0, 0]],
        [[np.nan, 0], [0, 1]],
        [[np.inf, 0], [0, np.inf]],
        [[1e12, 0], [0, 1e12]],
    ]
)
NOT_PLACES = np.array([np.inf, -np.inf, np.nan])


def bad_covariances(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Give every second detection what is no covariance."""
    return [_every_second(each, 'covariance', NOT_COVARIANCES, rng) for each in messages]


def infinite_positions(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Put every second detection nowhere."""
    places = np.column_stack([NOT_PLACES, rng.permutation(NOT_PLACES), np.zeros(3)])
    return [_every_second(each, 'position', places, rng) for each in messages]


def far_positions(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Put every second detection farther than there are numbers for its cells."""
    places = np.array([[1e30, 1e30, 0], [-1e30, 1.0, 0], [1e15, -1e15, 0], [1e9, 1e9, 0]])
    return [_every_second(each, 'position', places, rng) for each in messages]


def flood(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Add ten thousand detections all over the area, once."""
    return messages if step else lasting_flood(messages, step, rng)


def lasting_flood(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Add ten thousand detections all over the area, tick after tick."""
    count = FLOOD // len(messages)
    return [_with(each, rng.uniform((0, 0), (105, 68), (count, 2))) for each in messages]


def spot_flood(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Add ten thousand detections of one camera within a metre, once."""
    if step:
        return messages
    return [_with(messages[0], rng.normal(SPOT_M, 0.5, (FLOOD, 2))), *messages[1:]]


def empty(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Let all cameras see nothing."""
    return [
        CameraDetections(each.camera, Detections.build(each.rows.stamp_ns)) for each in messages
    ]


def silent(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Let all cameras send nothing."""
    return []


def twice(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Send every message twice, and once more with a later stamp."""
    later = [
        CameraDetections(
            each.camera, Detections.joined(each.rows.stamp_ns + 1_000_000, [each.rows])
        )
        for each in messages
    ]
    return [*messages, *messages, *later]


def unknown_camera(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Send every message again as if from a camera that the site does not have."""
    return [*messages, *(CameraDetections('nobody', each.rows) for each in messages)]


def wild_ids(messages: Messages, step: int, rng: np.random.Generator) -> Messages:
    """Name tracks, groups and classes that do not exist."""
    return [_with_wild_ids(each, rng) for each in messages]


SPOILERS: Mapping[str, Spoiler] = {
    'bad_covariances': bad_covariances,
    'infinite_positions': infinite_positions,
    'far_positions': far_positions,
    'flood': flood,
    'spot_flood': spot_flood,
    'lasting_flood': lasting_flood,
    'empty': empty,
    'silent': silent,
    'twice': twice,
    'unknown_camera': unknown_camera,
    'wild_ids': wild_ids,
}


def _every_second(
    message: CameraDetections, column: str, values: NDArray[Any], rng: np.random.Generator
) -> CameraDetections:
    """Give every second row one of some values."""
    spoiled = getattr(message.rows, column).copy()
    spoiled[::2] = rng.choice(values, len(spoiled[::2]))
    return CameraDetections(message.camera, message.rows.replace(**{column: spoiled}))


def _with(message: CameraDetections, place: NDArray[np.float64]) -> CameraDetections:
    """Add detections at (n, 2) places, m."""
    more = Detections.build(
        message.rows.stamp_ns,
        position=np.column_stack([place, np.zeros(len(place))]),
        covariance=np.broadcast_to(0.1 * np.eye(2), (len(place), 2, 2)),
    )
    rows = Detections.joined(message.rows.stamp_ns, [message.rows, more])
    return CameraDetections(message.camera, rows)


def _with_wild_ids(message: CameraDetections, rng: np.random.Generator) -> CameraDetections:
    count = len(message.rows)
    wild = rng.integers(MOST_ID - 100, MOST_ID, (count, 2))
    rows = message.rows.replace(
        local_id=wild[:, 0],
        track_id=wild[:, 1],
        members=rng.integers(0, MOST_ID, (count, MEMBERS)),
        member_count=rng.choice([0, 1, 2, 255], count, p=[0.1, 0.7, 0.1, 0.1]),
        class_id=rng.integers(0, 256, count),
        kit=rng.integers(0, 256, count),
    )
    return CameraDetections(message.camera, rows)
