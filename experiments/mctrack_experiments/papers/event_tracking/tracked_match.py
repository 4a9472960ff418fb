"""A simulated match, rendered and tracked: what happened beside what was told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from mctrack_experiments.papers.event_tracking.happenings import (
    Happening,
    People,
    told_happenings,
    true_happenings,
)
from mctrack_experiments.papers.event_tracking.kits import KitScore, score_kits
from mctrack_ros.codec import jpeg_from_image
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.instants import TRACKS_TOPIC, TRUTH_TOPIC, read_instants
from mctrack_ros.interfaces import Detections, Events, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.track import Source, track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import CameraRenderer, World
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import SiteConfig, load_site

PEOPLE_GATE_M = 1.5
"""A track stands for nobody who is farther away, m."""

MEMORY_S = 1.0
"""A track is whom it is nearest to most often within this time, s."""


@dataclass(frozen=True)
class TrackedMatch:
    """
    The bags of a match on ``pitch5``.

    Attributes
    ----------
    match, tracked : Path
        The rendered bag with its truth, and what was made of it.
    cameras : tuple of str
        Names.

    """

    match: Path
    tracked: Path
    cameras: tuple[str, ...]

    @classmethod
    def made(
        cls, world: World, folder: Path, is_given: bool = True, first_pass: bool = True
    ) -> TrackedMatch:
        """
        Render what goes on and track it, all in a folder.

        The cameras are given images of the empty pitch, or learn their backgrounds from the match:
        in a first pass, or as live ones do.
        """
        simulate(world.scenario, folder / 'match', world=world)
        site = load_site(config_file('pitch5.yaml'))
        cameras = {camera.name: site.cameras[camera.name] for camera in world.cameras}
        site = replace(site, cameras=cameras)
        if is_given:
            site = with_backgrounds(site, world, folder)
        track_bag(Source(folder / 'match', first_pass=first_pass), folder / 'out', site)
        return cls(folder / 'match', folder / 'out' / 'bag', site.camera_names)

    def happenings(self, camera: str) -> tuple[list[Happening], list[Happening]]:
        """Return a camera's true events, and those that it told of, both with true ids."""
        with BagReader(self.match) as bag:
            seen = [rows for rows, _ in bag.rows(f'/truth/{camera}/detections', Detections)]
            topic = f'/truth/{camera}/events'
            events = bag.rows(topic, Events) if topic in bag.topics else ()
            true = true_happenings(rows for rows, _ in events)
        with BagReader(self.tracked) as bag:
            found = (rows for rows, _ in bag.rows(f'/{camera}/detections', Detections))
            people = People(seen, found, PEOPLE_GATE_M, MEMORY_S)
            told = (rows for rows, _ in bag.rows(f'/{camera}/events', Events))
            return true, told_happenings(told, people, self.everybody)

    def trajectories(self) -> tuple[Trajectories, Trajectories]:
        """Return everybody's true trajectories, and those of the global tracks."""
        true, found = self._instants
        period_ns = true[1].stamp_ns - true[0].stamp_ns
        truth, tracks = (Trajectories.from_tracks(each, period_ns, 0) for each in (true, found))
        return truth, tracks

    def kits(self, gate_m: float) -> KitScore:
        """Return how well the kits of the global tracks are told."""
        return score_kits(*self._instants, gate_m)

    @property
    def start_ns(self) -> int:
        """Return when it begins."""
        return self._instants[0][0].stamp_ns

    @property
    def rate_hz(self) -> float:
        """Return its images a second."""
        first, second = (rows.stamp_ns for rows in self._instants[0][:2])
        return 1e9 / (second - first)

    @cached_property
    def everybody(self) -> People:
        """Return whom the global tracks stand for."""
        return People(*self._instants, PEOPLE_GATE_M, MEMORY_S, 'track_id')

    @cached_property
    def _instants(self) -> tuple[Sequence[Tracks], Sequence[Tracks]]:
        truth = read_instants(self.match, (TRUTH_TOPIC,)).instants
        return truth, read_instants(self.tracked, (TRACKS_TOPIC,)).instants


def with_backgrounds(site: SiteConfig, world: World, folder: Path) -> SiteConfig:
    """Return a world's cameras, each with one JPEG that it took of the empty pitch."""
    cameras = {}
    for index, camera in enumerate(world.cameras):
        path = folder / f'{camera.name}.jpg'
        path.write_bytes(jpeg_from_image(CameraRenderer(world, index).empty()).tobytes())
        cameras[camera.name] = replace(site.cameras[camera.name], background=str(path))
    return replace(site, cameras=cameras)
