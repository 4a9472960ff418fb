"""Videos of a run's cameras, and which of them show a track."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy import select

from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.queries.results import Showing
from mctrack_ros.store.queries.run import ALWAYS, Between, Run
from mctrack_ros.store.queries.tracks import episodes
from mctrack_ros.store.runs import number_of
from mctrack_ros.store.schema import CAMERAS, RUN_CAMERAS, VIDEOS


@dataclass(frozen=True, slots=True)
class VideoFile:
    """
    A video of a camera.

    Attributes
    ----------
    camera : str
        Name of the camera.
    path : str
        The file.
    began_ns, ended_ns : int
        Stamps of its first and last image, ns.

    """

    camera: str
    path: str
    began_ns: int
    ended_ns: int


def link_videos(run: Run, videos: Sequence[VideoFile]) -> None:
    """
    Link videos to the cameras of a run.

    Raises
    ------
    StoreError
        If the run has no such camera.

    """
    asked = select(CAMERAS.c.name, CAMERAS.c.camera_id).join(RUN_CAMERAS)
    with run.database.connected() as connection:
        rows = connection.execute(asked.where(RUN_CAMERAS.c.run_id == run.stored.run)).all()
        numbers = {row.name: row.camera_id for row in rows}
        for video in videos:
            if video.camera not in numbers:
                raise StoreError(f'run {run.name} has no camera {video.camera}')
            values = {
                'camera_id': numbers[video.camera],
                'path': video.path,
                'began_ns': video.began_ns,
                'ended_ns': video.ended_ns,
            }
            number_of(connection, VIDEOS, values)


def showings(run: Run, track: int, between: Between = ALWAYS) -> list[Showing]:
    """Return which videos show a track, and where in them; a camera shows whom it detects."""
    asked = select(RUN_CAMERAS.c.bit, CAMERAS.c.name, VIDEOS).select_from(
        RUN_CAMERAS.join(CAMERAS, CAMERAS.c.camera_id == RUN_CAMERAS.c.camera_id).join(
            VIDEOS, VIDEOS.c.camera_id == CAMERAS.c.camera_id
        )
    )
    with run.database.connected() as connection:
        condition = RUN_CAMERAS.c.run_id == run.stored.run
        videos = connection.execute(asked.where(condition)).all()
    rows = run.rows(between, tracks=[track], whole=True)
    cameras = rows.column('cameras')
    found = []
    for video in videos:
        shown = (cameras >> np.uint32(video.bit)) & 1 == 1
        shown &= (rows.stamp_ns >= video.began_ns) & (rows.stamp_ns <= video.ended_ns)
        stamp_ns = rows.stamp_ns[shown]
        for part in episodes(stamp_ns, rows.life[shown], rows.life[shown]):
            first, last = int(stamp_ns[part[0]]), int(stamp_ns[part[-1]])
            found.append(
                Showing(
                    video.name,
                    video.path,
                    track,
                    run.seconds(first),
                    run.seconds(last),
                    (first - video.began_ns) / 1e9,
                    (last - video.began_ns) / 1e9,
                )
            )
    return sorted(found, key=lambda each: (each.began_s, each.camera))
