"""The history of a track around an instant: stored in a bag, or fused again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import numpy as np

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import FusionConfig, JointConfig, OpenViews
from mctrack_ros.fusion.management.lifecycle import GONE_EVIDENCE
from mctrack_ros.fusion.occupancy.config import OccupancyConfig
from mctrack_ros.fusion.occupancy.pipeline import ALL
from mctrack_ros.fusion.trackers import no_views
from mctrack_ros.interfaces import Candidates, Decisions, Explanation, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.recorded import recorded_settings, recorded_ticks
from mctrack_ros.replay.results import CANDIDATES_TOPIC, DECISIONS_TOPIC
from mctrack_ros.site.site import SiteConfig

TRACKS_TOPIC = '/tracks'
TRAIL_S = 2.0
"""How much of the time before is part of it, s."""


@dataclass(frozen=True, eq=False, slots=True)
class TrackHistory:
    """
    What is known of an instant and of what was before and after.

    Attributes
    ----------
    track_id : int
        Whose history it is, as the user named it.
    cameras : tuple of str
        Names in the site's order.
    start_ns : int
        Stamp of the bag's first tick, from which seconds count.
    explanations : tuple of Explanation
        Of ticks in order, the instant asked about among them.
    index : int
        Which it is.
    gate : float
        Largest squared Mahalanobis distance of a pair.
    gone : float
        Log-odds of having gone from which a track is published no longer.
    is_stored : bool
        Whether the bag held the explanations; else its detections were fused again.
    is_same : bool
        Whether the tracks at that instant are those that the bag holds, if it holds any.

    """

    track_id: int
    cameras: tuple[str, ...]
    start_ns: int
    explanations: tuple[Explanation, ...]
    index: int
    gate: float
    gone: float
    is_stored: bool
    is_same: bool

    @property
    def now(self) -> Explanation:
        """The instant asked about."""
        return self.explanations[self.index]

    def seconds(self, stamp_ns: int) -> float:
        """Return a stamp in s since the bag's first tick."""
        return (stamp_ns - self.start_ns) * 1e-9


def history_of(
    bag: str | Path,
    track_id: int,
    at_s: float,
    for_s: float = 0.0,
    site: SiteConfig | None = None,
    namespace: str = '',
) -> TrackHistory:
    """
    Find out why a track was treated as it was.

    Parameters
    ----------
    bag : str or Path
        With explanations, or with the detections of all cameras from its start on.
    track_id : int
        The track.
    at_s, for_s : float
        Of the tick next to that time, since the bag's first tick, and for so long after, s.
    site : SiteConfig, optional
        How fusion was set; unless given, as the bag's ``/site`` says.
    namespace : str
        Where the topics lie in the bag.

    Raises
    ------
    BagError
        If the bag cannot be read, or holds neither explanations nor detections.
    ConfigError
        If the bag does not say how fusion was set and no site is given, or the site has other
        cameras than the bag.
    ValueError
        If the time is not within the bag, or there is no such track then.

    """
    with BagReader(bag, namespace) as reader:
        cameras, config = _settings(reader, site)
        start_ns = _first_tick_ns(reader, cameras, config)
        at_ns = start_ns + round(at_s * 1e9)
        half_ns = round(config.batching.period * 5e8)
        wanted = (at_ns - round(TRAIL_S * 1e9), at_ns + round(for_s * 1e9) + half_ns)
        reported = list(_stored(reader, *wanted))
        is_stored = any(abs(each.stamp_ns - at_ns) <= half_ns for each in reported)
        if not is_stored:
            views = no_views if site is None else site.views
            reported = list(_replayed(reader, cameras, config, *wanted, views))
        index = _nearest(reported, at_ns)
        if index is None or abs(reported[index].stamp_ns - at_ns) > 2 * half_ns:
            raise ValueError(_outside(reader, at_s, start_ns, cameras, config))
        now = reported[index].decisions
        _check_is_there(now, track_id, at_s)
        same = is_stored or _is_as_recorded(reader, now)
    return TrackHistory(
        track_id=track_id,
        cameras=(ALL,) if isinstance(config, OccupancyConfig) else cameras,
        start_ns=start_ns,
        explanations=tuple(reported),
        index=index,
        gate=config.association.gate,
        gone=GONE_EVIDENCE,
        is_stored=is_stored,
        is_same=same,
    )


def _settings(reader: BagReader, site: SiteConfig | None) -> tuple[tuple[str, ...], JointConfig]:
    """Return the cameras' names and how fusion was set; only the joint tracker explains."""
    cameras, config = recorded_settings(reader, site)
    if not isinstance(config, JointConfig):
        raise ConfigError(f'fusion.tracker is {config.tracker}: it does not say why; joint does')
    return cameras, config


def _first_tick_ns(reader: BagReader, cameras: tuple[str, ...], config: FusionConfig) -> int:
    """Return the stamp of the first tick: of the tracks, or of what would be fused first."""
    for topic, kind in ((TRACKS_TOPIC, Tracks), (DECISIONS_TOPIC, Decisions)):
        if reader.count(topic):
            return next(rows.stamp_ns for rows, _ in reader.rows(topic, kind))
    return next(recorded_ticks(reader, cameras, config)).stamp_ns


def _stored(reader: BagReader, begin_ns: int, end_ns: int) -> Iterator[Explanation]:
    """Yield the explanations that the bag holds of some time."""
    if not reader.count(CANDIDATES_TOPIC) or not reader.count(DECISIONS_TOPIC):
        return
    candidates = {rows.stamp_ns: rows for rows, _ in reader.rows(CANDIDATES_TOPIC, Candidates)}
    for decisions, _ in reader.rows(DECISIONS_TOPIC, Decisions):
        stamp_ns = decisions.stamp_ns
        if begin_ns <= stamp_ns <= end_ns and stamp_ns in candidates:
            yield Explanation(candidates[stamp_ns], decisions)


def _replayed(
    reader: BagReader,
    cameras: tuple[str, ...],
    config: FusionConfig,
    begin_ns: int,
    end_ns: int,
    views: OpenViews,
) -> Iterator[Explanation]:
    """Fuse the bag's detections from its start on, and yield why, of some time."""
    recorded = recorded_ticks(reader, cameras, config)
    ticks = takewhile(lambda tick: tick.stamp_ns <= end_ns, recorded)
    for ticked in drive(config, cameras, ticks, lambda tick: tick.stamp_ns >= begin_ns, views):
        if ticked.explanation is not None:
            yield ticked.explanation


def _nearest(reported: list[Explanation], at_ns: int) -> int | None:
    gaps = [abs(each.stamp_ns - at_ns) for each in reported]
    return int(np.argmin(gaps)) if gaps else None


def _outside(
    reader: BagReader,
    at_s: float,
    start_ns: int,
    cameras: tuple[str, ...],
    config: FusionConfig,
) -> str:
    topic = TRACKS_TOPIC if reader.count(TRACKS_TOPIC) else ''
    stamps = (
        [rows.stamp_ns for rows, _ in reader.rows(topic, Tracks)]
        if topic
        else [tick.stamp_ns for tick in recorded_ticks(reader, cameras, config)]
    )
    last = (max(stamps) - start_ns) * 1e-9
    return f'there is no tick at {at_s:g} s: those of {reader.path} are from 0 to {last:.2f} s'


def _check_is_there(decisions: Decisions, track_id: int, at_s: float) -> None:
    known = np.union1d(decisions.track_id, decisions.previous_id[decisions.previous_id > 0])
    if track_id not in known:
        ids = ', '.join(map(str, decisions.track_id.tolist())) or 'none'
        raise ValueError(f'there is no track {track_id} at {at_s:g} s; there are: {ids}')


def _is_as_recorded(reader: BagReader, decisions: Decisions) -> bool:
    """Tell whether the bag's own tracks of that instant, if any, are among these."""
    if not reader.count(TRACKS_TOPIC):
        return True
    for tracks, _ in reader.rows(TRACKS_TOPIC, Tracks):
        if tracks.stamp_ns == decisions.stamp_ns:
            places = dict(zip(decisions.track_id.tolist(), decisions.position.tolist()))
            return all(
                places.get(one) == place
                for one, place in zip(tracks.track_id.tolist(), tracks.position.tolist())
            )
    return False
