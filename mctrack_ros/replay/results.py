"""Output files of a run: a bag, and the tracks as text."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import yaml

from mctrack_ros.interfaces import Foreground, Message
from mctrack_ros.recording import PARAMETERS, BagWriter, MotTextWriter, TrackTableWriter
from mctrack_ros.recording.closing import Closing
from mctrack_ros.replay.drive import TickOutput
from mctrack_ros.replay.lockstep import Results, tick_ns
from mctrack_ros.site.portable import portable_site
from mctrack_ros.site.site import SiteConfig

CANDIDATES_TOPIC = '/explanation/candidates'
DECISIONS_TOPIC = '/explanation/decisions'


class RunFiles(Closing):
    """
    Write ``bag``, ``tracks.txt`` and ``tracks.csv``; text has the coordinates of the site's files.

    The bag of a private site holds no masks, which show silhouettes.

    Parameters
    ----------
    folder : Path
        Folder of the files.
    site : SiteConfig
        Cameras and settings.
    overwrite : bool
        Whether a bag already there is replaced.

    """

    def __init__(self, folder: Path, site: SiteConfig, *, overwrite: bool) -> None:
        period_ns, _ = tick_ns(site)
        self._site, self._times, self._is_empty = site, _LogTimes(period_ns), True
        with ExitStack() as opened:
            self._bag = opened.enter_context(BagWriter(folder / 'bag', overwrite=overwrite))
            self._texts = [
                opened.enter_context(kind(folder / name, period_ns, origin=site.origin))
                for name, kind in (('tracks.txt', MotTextWriter), ('tracks.csv', TrackTableWriter))
            ]
            if site.path:
                self._bag.attach(portable_site(site.path), 'application/octet-stream')
            parameters = yaml.safe_dump(site.values(), sort_keys=False)
            self._bag.attach({PARAMETERS: parameters.encode()}, 'application/yaml')
            self._opened = opened.pop_all()

    def write(self, results: Results, ticked: TickOutput) -> None:
        """Append one tick; before the first one, the description of the site."""
        stamp_ns = ticked.tick.stamp_ns
        if self._is_empty:
            self._bag.write_text('/site', self._site.description(stamp_ns), stamp_ns)
            self._is_empty = False
        now_ns = self._times.log_ns(stamp_ns, results[0].session)
        for topic, rows in _topics(results, ticked):
            if self._site.private and isinstance(rows, Foreground):
                continue
            self._bag.write_rows(topic, rows, self._site.ground_frame, now_ns)
        for text in self._texts:
            text.write(ticked.output.tracks)

    def close(self) -> None:
        """Finish the files."""
        self._opened.close()


class _LogTimes:
    """Log times of ticks: their stamps, continued where time begins anew."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._last_ns = self._added_ns = self._session = 0

    def log_ns(self, stamp_ns: int, session: int) -> int:
        """Return the log time, ns, of a tick; the session counts how often time began anew."""
        if session > self._session:
            self._session = session
            self._added_ns = self._last_ns + self._period_ns - stamp_ns
        self._last_ns = stamp_ns + self._added_ns
        return self._last_ns


def _topics(results: Results, ticked: TickOutput) -> Iterator[tuple[str, Message]]:
    """
    Yield topics and rows of one tick, in a fixed order.

    Like the nodes, write no message of events where there are none.
    """
    for result in results:
        if len(result.events):
            yield f'/{result.camera}/events', result.events
        for topic, rows in result.messages.items():
            yield f'/{result.camera}/{topic}', rows
    yield '/ticks', ticked.tick.record
    yield '/tracks', ticked.output.tracks
    if len(ticked.output.events):
        yield '/events', ticked.output.events
    yield f'/{ticked.feedback.TOPIC}', ticked.feedback
    if ticked.explanation is not None:
        yield CANDIDATES_TOPIC, ticked.explanation.candidates
        yield DECISIONS_TOPIC, ticked.explanation.decisions
