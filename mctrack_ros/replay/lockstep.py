"""
The whole system over a bag, in lock step: the same cores that the nodes drive, without DDS.

A tick is fused once every camera has passed it, and an image is processed once the feedback it
uses is known, so the outcome depends on the bag and the configuration alone, however many
processes share the work.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from mctrack_ros.fusion import FusionConfig, fusion_method, joined, open_batcher
from mctrack_ros.interfaces import Detections, Rows, RowsTick
from mctrack_ros.replay.camera_source import CameraResult, CameraTask
from mctrack_ros.replay.drive import TickOutput, drive
from mctrack_ros.replay.workers import NEVER, CameraWorkers, Progress
from mctrack_ros.site.site import SiteConfig

Results = tuple[CameraResult, ...]
"""Results of all cameras in one period, by camera and stamp."""


class ReplayError(RuntimeError):
    """A replay that cannot go on."""


def camera_tasks(bag: str | Path, site: SiteConfig, namespace: str = '') -> list[CameraTask]:
    """Return the tasks of a site's cameras over a bag."""
    if site.cells:
        raise ReplayError(f'the site {site.name} has cells, no cameras: track the site of each')
    period_ns, delay_ns = tick_ns(site)
    kinds = fusion_method(site.fusion).messages
    return [
        CameraTask(Path(bag), name, settings, period_ns, delay_ns, namespace, kinds=kinds)
        for name, settings in site.cameras.items()
    ]


def tick_ns(site: SiteConfig) -> tuple[int, int]:
    """
    Return tick period and feedback delay, ns.

    Raises
    ------
    ReplayError
        If the feedback were needed before it exists.

    """
    period_ns = round(site.fusion.batching.period * 1e9)
    delay_ns = round(site.feedback_delay * 1e9)
    if delay_ns < period_ns:
        raise ReplayError(
            f'feedback_delay is {site.feedback_delay} s, expected at least the period, '
            f'{site.fusion.batching.period} s: feedback of the running tick does not exist yet'
        )
    return period_ns, delay_ns


def run_lockstep(
    workers: CameraWorkers,
    site: SiteConfig,
    *,
    explain: bool = False,
    starts: Iterable[Detections] = (),
) -> Iterator[tuple[Results, TickOutput]]:
    """
    Run the cameras and the fusion of a site over a bag; fusion runs in the caller's process.

    Parameters
    ----------
    workers : CameraWorkers
        Processes with the `camera_tasks` of the bag.
    site : SiteConfig
        Cameras and settings.
    explain : bool
        Whether it is taken down why fusion decides as it does.
    starts : iterable of Detections
        Tracks that are started and ended from outside; see `drive`.

    Yields
    ------
    results : tuple of CameraResult
        Results of all cameras in a period, by camera and stamp.
    ticked : TickOutput
        One for each tick, in order.

    Raises
    ------
    BagError, CalibrationError, ConfigError, ReplayError, ValueError
        If the input cannot be used.

    """
    batches = Batches(site.fusion, site.camera_names)
    periods = _Periods(workers, round(site.fusion.batching.period * 1e9))
    ticks = (tick for results in periods.complete() for tick in batches.ticks(results))
    asked, zones = (lambda tick: explain), site.own_zones
    driven = drive(site.fusion, site.camera_names, ticks, asked, site.views, starts, zones)
    for ticked in driven:
        periods.feedback.append((batches.session, ticked.feedback))
        yield periods.results, ticked


class _Periods:
    """
    Results of the cameras, period by period.

    Parameters
    ----------
    workers : CameraWorkers
        Processes with the cameras.
    period_ns : int
        Length of a period, ns.

    Attributes
    ----------
    results : tuple of CameraResult
        Those of the last complete period.
    feedback : list of (int, Rows)
        Feedback since the last announcement, by session; the caller appends.

    """

    def __init__(self, workers: CameraWorkers, period_ns: int) -> None:
        self._workers, self._period_ns = workers, period_ns
        self.results: Results = ()
        self.feedback: list[tuple[int, Rows]] = []

    def complete(self) -> Iterator[Results]:
        """Yield the results of each period that all cameras have passed; announce feedback."""
        pending: dict[int, list[CameraResult]] = defaultdict(list)
        complete_to = -1
        next_tick = dict.fromkeys(self._workers.connections, -1)
        open_connections = list(self._workers.connections)
        while open_connections:
            for connection in wait(open_connections):
                assert isinstance(connection, Connection)
                progress = _received(connection)
                for result in progress.results:
                    pending[result.tick(self._period_ns)].append(result)
                next_tick[connection] = progress.next_tick
                if progress.next_tick == NEVER:
                    open_connections.remove(connection)
                    self._workers.ended(progress)
            passed = min(next_tick.values()) - 1
            for index in sorted(index for index in pending if index <= passed):
                self.results = in_order(pending.pop(index))
                yield self.results
            if passed > complete_to:
                complete_to = passed
                self._workers.announce(complete_to, self.feedback)
                self.feedback = []


def _received(connection: Connection) -> Progress:
    """Take a report of a process."""
    try:
        report = connection.recv()
    except EOFError as error:
        raise ReplayError('a camera process died') from error
    if isinstance(report, Exception):
        raise report
    assert isinstance(report, Progress)
    return report


def in_order(results: list[CameraResult]) -> Results:
    """Return results of one period by camera and stamp."""
    return tuple(sorted(results, key=lambda r: (r.camera, r.stamp_ns)))


class Batches:
    """
    Makes ticks of the results of one period after another; nothing is late.

    Parameters
    ----------
    config : FusionConfig
        Its `batching` is used.
    cameras : tuple of str
        Names in the site's order.

    Attributes
    ----------
    session : int
        Counts how often time has begun anew.

    """

    def __init__(self, config: FusionConfig, cameras: tuple[str, ...]) -> None:
        self._batcher = open_batcher(config, cameras)
        self._method = fusion_method(config)
        self.session = 0

    def ticks(self, results: Results) -> list[RowsTick[Any]]:
        """Return the ticks of the results of one period, which are in order."""
        if results[0].session > self.session:
            self.session = results[0].session
            self._batcher.begin_anew()
        now_ns = min(result.stamp_ns for result in results)
        ticks = []
        for result in results:
            self._batcher.feedback_missed(result.camera, int(result.feedback_missed))
            rows = joined(self._method, result.messages)
            ticks += self._batcher.add(result.camera, rows, now_ns)
        return ticks + self._batcher.flush()
