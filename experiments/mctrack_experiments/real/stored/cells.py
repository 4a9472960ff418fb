"""Real detections through two cells, each with half of the cameras, and a site above them."""

from __future__ import annotations

from dataclasses import replace

from mctrack_experiments.bench.cells.play import Arrival, play_site, timed
from mctrack_experiments.datasets.stored import StoredScene
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.cells.report import CellReport
from mctrack_ros.interfaces import Feedback
from mctrack_ros.replay.drive import drive

CELLS = 2


def track_in_cells(scene: StoredScene) -> Trajectories:
    """
    Fuse detections in two cells that see the same place, and their tracks.

    Parameters
    ----------
    scene : StoredScene
        Its truth is not looked at.

    Returns
    -------
    Trajectories
        Published, confirmed tracks of the site, numbered with the scene's frames.

    """
    tick_s, arrivals = 1 / scene.rate, []
    for cell in range(CELLS):
        cameras = scene.cameras[cell::CELLS]
        config = timed(JointConfig(), tick_s)
        for ticked in drive(config, cameras, scene.ticks(cameras)):
            assert isinstance(ticked.feedback, Feedback)
            report = CellReport(ticked.output.tracks, ticked.feedback)
            arrivals.append(Arrival(report.stamp_ns, cell, report))
    arrivals.sort(key=lambda each: (each.arrival_ns, each.cell))
    instants = play_site(arrivals, CELLS, tick_s).tracks
    rows = Trajectories.from_tracks(instants, round(1e9 / scene.rate))
    return replace(rows, frame=scene.frame[rows.frame])
