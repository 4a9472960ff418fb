"""The offsets of the cameras' clocks in a recording, told from who moves in several views."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.clock_offsets.clock_offsets import ClockOffset, ClockOffsets
from mctrack_ros.interfaces import Detections, Tracks
from mctrack_ros.recording import BagReader, stated_clock_offsets
from mctrack_ros.replay.doctor import Finding, Severity
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.site.site import SiteConfig

WINDOW_S = 600.0
"""Length of the end of a recording that counts: clocks drift by some ms in that time."""
TRACKS_TOPIC = '/tracks'


@dataclass(frozen=True, slots=True)
class CameraClock:
    """
    What is known of one camera's clock.

    Attributes
    ----------
    measured : ClockOffset
        By how much its own stamps are ahead; what a run has taken from them counts.
    stated_s, reference_s : float
        What the site says of its clock and of the reference's, s.

    """

    measured: ClockOffset
    stated_s: float
    reference_s: float

    def differs(self, limit_s: float) -> bool:
        """Tell whether the clock is surely off what is stated, by more than a limit."""
        left_s = abs(self.right_s - self.stated_s)
        return self.measured.is_known and left_s > max(limit_s, self.measured.half_s)

    @property
    def right_s(self) -> float:
        """What the site should say, s."""
        return self.measured.offset_s + self.reference_s

    def __str__(self) -> str:
        """Say it in a line."""
        one = self.measured
        if not one.reference:
            return 'nobody is seen by it and by another camera together'
        if not one.is_known:
            width = f'{one.half_s:.2f} s' if np.isfinite(one.half_s) else 'nothing'
            return f'not enough motion in common views: known to {width}'
        if one.reference == one.camera:
            return 'the reference'
        word = 'ahead of' if one.offset_s >= 0 else 'behind'
        return (
            f'its clock is {abs(one.offset_s):.3f} s {word} that of {one.reference}, '
            f'+- {one.half_s:.3f} s (95 %; standard deviation {one.deviation_s:.4f} s)'
        )


def camera_clocks(
    bag: str | Path, site: SiteConfig, namespace: str = ''
) -> tuple[CameraClock, ...]:
    """
    Measure the clocks by the detections of a recording.

    Who is who is told by the bag's tracks, else by the ids that cameras were told, else by
    tracking the detections.

    Parameters
    ----------
    bag : str or Path
        With detections of the site's cameras.
    site : SiteConfig
        Whose cameras these are.
    namespace : str
        Where their topics lie in the bag.

    Raises
    ------
    BagError
        If there are no detections.

    """
    cameras = site.camera_names
    offsets = ClockOffsets(cameras, WINDOW_S)
    with BagReader(bag, namespace) as reader:
        taken = stated_clock_offsets(reader)
        for _ in _given(reader, site, offsets):
            pass
    measured = [
        replace(
            one,
            offset_s=one.offset_s + taken.get(one.camera, 0.0) - taken.get(one.reference, 0.0),
        )
        for one in offsets.estimate()
    ]
    return tuple(
        CameraClock(
            one,
            site.cameras[one.camera].clock_offset,
            site.cameras[one.reference].clock_offset if one.reference else 0.0,
        )
        for one in measured
    )


def _given(reader: BagReader, site: SiteConfig, offsets: ClockOffsets) -> Iterator[bool]:
    """Give to an estimate what a bag says; yield whether it knows more."""
    config = JointConfig(batching=replace(site.fusion.batching, time_sync_limit=0.0))
    ticks = recorded_ticks(reader, site.camera_names, config)
    if reader.count(TRACKS_TOPIC):
        tracks = {rows.stamp_ns: rows for rows, _ in reader.rows(TRACKS_TOPIC, Tracks)}
        for tick in ticks:
            if tick.stamp_ns in tracks:
                yield offsets.add(tick, tracks[tick.stamp_ns])
        return
    given = list(ticks)
    if _names_targets(message.rows for tick in given for message in tick.messages):
        for tick in given:
            for message in tick.messages:
                yield offsets.add_reported(message.camera, message.rows)
        return
    for ticked in drive(config, site.camera_names, given):
        yield offsets.add(ticked.tick, ticked.output.tracks)


def _names_targets(images: Iterator[Detections]) -> bool:
    """Tell whether cameras name most of whom they detect."""
    known = count = 0
    for rows in images:
        known += int((rows.track_id > 0).sum())
        count += len(rows)
    return 2 * known > count


def findings(clocks: tuple[CameraClock, ...], limit_s: float) -> Iterator[Finding]:
    """
    Yield what is to be said of the clocks, and the line of the site YAML that corrects each.

    Parameters
    ----------
    clocks : tuple of CameraClock
        Of all cameras.
    limit_s : float
        A difference that is surely larger is a warning, s.

    """
    for clock in clocks:
        one = clock.measured
        if not one.is_known:
            remedy = 'record longer, while people walk through what two cameras see'
            yield Finding(Severity.NOTE, one.camera, str(clock), remedy)
        elif clock.differs(limit_s):
            remedy = f'set in the site, under the camera: clock_offset: {clock.right_s:.3f}'
            yield Finding(Severity.WARNING, one.camera, str(clock), remedy)
        else:
            yield Finding(Severity.NOTE, one.camera, str(clock), 'nothing is to be done')
