"""Small scenes for the tests of fusion."""

import numpy as np

from mctrack_ros.interfaces import CameraDetections, Detections, Tick, Ticks

PERIOD_NS = 40_000_000


def detections(stamp_ns, positions, sigma=0.1, **columns):
    positions = np.asarray(positions, float).reshape(-1, 2)
    return Detections.build(
        stamp_ns,
        position=np.column_stack([positions, np.zeros(len(positions))]),
        covariance=np.tile(sigma**2 * np.eye(2), (len(positions), 1, 1)),
        **columns,
    )


def tick(index, frames):
    stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
    named = tuple(
        CameraDetections(
            camera, rows if isinstance(rows, Detections) else detections(stamp_ns, rows)
        )
        for camera, rows in sorted(frames.items())
    )
    return Tick(stamp_ns, named, Ticks.build(stamp_ns))


def published(output):
    """Return id -> position of the confirmed tracks."""
    tracks = output.tracks
    shown = (tracks.status != 0) & (tracks.status != 4)
    return {
        int(track_id): position[:2]
        for track_id, position in zip(tracks.track_id[shown], tracks.position[shown])
    }
