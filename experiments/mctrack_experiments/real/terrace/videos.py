"""
EPFL terrace: two real, synchronised videos, tracked live.

What is said of a live run needs no truth: whether both cameras put the same person at the same
spot, how steady the count of people is, and whether it keeps up with the cameras.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from mctrack_experiments.datasets.epfl_terrace import (
    PERIOD_NS,
    SIZE,
    VIDEO_FOLDER,
    top_view_from_image,
)
from mctrack_experiments.real.continuity import isolated_breaks
from mctrack_ros.codec import rows_from_cloud
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import REPORTED, Detections, Ticks, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.site.site import SiteConfig, load_site

CAMERAS = ('c0', 'c1')
METRES_PER_TOP_VIEW_PX = 0.0215
WATERMARK = (slice(228, 288), slice(126, 356))
"""Rows and columns of the logo burned into the clips."""

START_S = 2.0
BREAK_S = 1.5
_NEAR_M = 1.5


def video(data: Path, camera: str) -> Path:
    """Return the clip of a camera below the folder of real data."""
    return data / VIDEO_FOLDER / f'terrace1-{camera}.mp4'


def watermark_mask() -> NDArray[np.uint8]:
    """Return the image that is 0 where the clips have their logo."""
    mask = np.full((SIZE[1], SIZE[0]), 255, np.uint8)
    mask[WATERMARK] = 0
    return mask


def write_site(data: Path, folder: Path) -> SiteConfig:
    """
    Write the site of the two cameras into a folder and read it.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    folder : Path
        Where calibrations, mask and site go.

    """
    to_metres = np.diag([METRES_PER_TOP_VIEW_PX, METRES_PER_TOP_VIEW_PX, 1.0])
    cv2.imwrite(str(folder / 'mask.png'), watermark_mask())
    cameras = {}
    for camera in CAMERAS:
        matrix = (to_metres @ top_view_from_image(data, camera)).tolist()
        (folder / f'{camera}.yaml').write_text(yaml.safe_dump({'ground_from_image': matrix}))
        cameras[camera] = {
            'calibration': f'{camera}.yaml',
            'mask': 'mask.png',
            'image_width': SIZE[0],
            'image_height': SIZE[1],
        }
    site = {'name': 'terrace', 'cameras': cameras}
    (folder / 'site.yaml').write_text(yaml.safe_dump(site))
    return load_site(folder / 'site.yaml')


def terrace_figures(bag: Path, seconds: float) -> Figures:
    """
    Measure a recording of the live run.

    Parameters
    ----------
    bag : Path
        With ``/tracks``, ``/ticks`` and both cameras' detections, logged on arrival.
    seconds : float
        How much of the clips was played, s.

    """
    with BagReader(bag) as reader:
        tracks, logged = [], []
        for _, message, time_ns in reader.messages(['/tracks']):
            tracks.append(rows_from_cloud(message, Tracks))
            logged.append(time_ns)
        ticks = [rows_from_cloud(m, Ticks) for _, m, _ in reader.messages(['/ticks'])]
        detections = [_detections(reader, camera) for camera in CAMERAS]
    since_ns = tracks[0].stamp_ns + round(START_S * 1e9)
    shown = [rows.select(np.isin(rows.status, REPORTED)) for rows in tracks]
    stamps = np.array([rows.stamp_ns for rows in tracks])
    latency_ms = (np.array(logged) - stamps)[stamps >= since_ns] * 1e-6
    distance = _disagreement(shown, detections)
    counts = np.array([len(rows) for rows in shown])
    late = [rows for rows in ticks if rows.stamp_ns >= since_ns]
    return Figures(
        name='terrace_live',
        command='mctrack reproduce terrace --live',
        protocol={
            'mode': 'live: two video_nodes, two camera_nodes, fusion_node, recorder, over DDS',
            'seconds': seconds,
            'cameras': list(CAMERAS),
            'agreement': "distance of the two cameras' detections of one track, both whole "
            f'and single, nearest within {_NEAR_M} m; the truth is not used',
            'isolated_breaks': f'a track ends, another begins within 1.5 m and {BREAK_S:g} s, '
            'nobody else within 2 m',
            'late_and_latency': f'after the first {START_S:g} s',
        },
        figures={
            'terrace.agreement_median_m': float(np.median(distance)),
            'terrace.agreement_p90_m': float(np.percentile(distance, 90)),
            'terrace.pairs': len(distance),
            'terrace.people_mean': float(counts.mean()),
            'terrace.count_changes_per_minute': float(
                np.count_nonzero(np.diff(counts)) / (len(counts) / 25 / 60)
            ),
            'terrace.isolated_breaks': isolated_breaks(
                Trajectories.from_tracks(shown, PERIOD_NS), round(BREAK_S * 1e9 / PERIOD_NS)
            ),
            'terrace.track_ids': len({int(i) for rows in shown for i in rows.track_id}),
            'terrace.realtime_factor': float((stamps[-1] - stamps[0]) / (logged[-1] - logged[0])),
            'terrace.latency_p50_ms': float(np.percentile(latency_ms, 50)),
            'terrace.latency_p99_ms': float(np.percentile(latency_ms, 99)),
            'terrace.ticks': len(ticks),
            'terrace.late_messages': sum(int(rows.late.sum()) for rows in late),
        },
    )


def _detections(reader: BagReader, camera: str) -> dict[int, Detections]:
    """Return a camera's detections by stamp."""
    messages = reader.messages([f'/{camera}/detections'])
    rows = (rows_from_cloud(message, Detections) for _, message, _ in messages)
    return {each.stamp_ns: each for each in rows}


def _disagreement(
    shown: Sequence[Tracks], detections: Sequence[dict[int, Detections]]
) -> NDArray[np.float64]:
    """Return how far apart two cameras put the same track, (n,) m."""
    apart = [np.zeros(0)]
    for tracks in shown:
        seen = tracks.select(tracks.cameras == 0b11).position[:, :2].astype(np.float64)
        images = [by_stamp.get(tracks.stamp_ns) for by_stamp in detections]
        if not len(seen) or any(image is None for image in images):
            continue
        spots = [_nearest(seen, image) for image in images if image is not None]
        distance = np.linalg.norm(spots[0] - spots[1], axis=1)
        apart.append(distance[np.isfinite(distance)])
    return np.concatenate(apart)


def _nearest(places: NDArray[np.float64], image: Detections) -> NDArray[np.float64]:
    """Return the whole, single detection nearest to each place, (n, 2) m; NaN: none is near."""
    whole = image.select((image.member_count == 1) & (image.truncated == 0))
    if not len(whole):
        return np.full(places.shape, np.nan)
    spots = whole.position[:, :2].astype(np.float64)
    distance = np.linalg.norm(places[:, None] - spots[None], axis=2)
    found: NDArray[np.float64] = spots[distance.argmin(axis=1)]
    found[distance.min(axis=1) > _NEAR_M] = np.nan
    return found
