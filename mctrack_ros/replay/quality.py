"""Use of the data of a run, camera by camera, as `/diagnostics` reports it live."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from statistics import median

import numpy as np

SECOND_NS = 1_000_000_000
LEFT_OUT = -1
"""Stamp of a message that is not used."""

PACE_SLACK = 1.1
"""Ratio of the tick's length to the fastest camera's interval up to which they agree."""
JUMP_REMEDY = 'keep the clocks in step by NTP or PTP, or track recordings one by one'
"""What to do about a jump of all cameras' stamps."""

_PAUSE_NS = 10 * SECOND_NS
"""A longer silence is a pause, not a loss of messages."""


@dataclass
class Stamps:
    """
    What is made of the stamps of one camera's messages, in the order of the bag.

    Attributes
    ----------
    stamp_ns : list of int
        When each was captured, ns, as it is used; `LEFT_OUT`: it is not.
    session : list of int
        Counts how often time had begun anew before each.
    late : int
        Messages that came again, or up to a second back.
    left_out : int
        Messages whose stamps cannot be believed.
    left_out_s : list of float
        By how much each of those is ahead of the other cameras, s; without those that a jump of
        all cameras' clocks explains.
    jumped_at : list of int
        Which messages are the first after a jump of the camera's clock.
    added_s : float
        What is added to the stamps in the end, s.

    """

    stamp_ns: list[int] = field(default_factory=list)
    session: list[int] = field(default_factory=list)
    late: int = 0
    left_out: int = 0
    left_out_s: list[float] = field(default_factory=list)
    jumped_at: list[int] = field(default_factory=list)
    added_s: float = 0.0

    def lost(self) -> int:
        """Return how many messages were lost in the gaps between the stamps."""
        stamps = np.array(self.stamp_ns, np.int64)
        (used,) = np.nonzero(stamps != LEFT_OUT)
        gaps = np.diff(stamps[used])
        after = np.searchsorted(used, self.jumped_at)
        gaps[after[(after > 0) & (after < len(used))] - 1] = 0
        gaps = gaps[(gaps > 0) & (gaps < _PAUSE_NS)]
        if not len(gaps):
            return 0
        return int(np.maximum(np.round(gaps / np.median(gaps)) - 1, 0).sum())

    def interval_s(self) -> float:
        """Return the median time between used messages, s; 0: there are fewer than two."""
        used = [stamp for stamp in self.stamp_ns if stamp != LEFT_OUT]
        return float(np.median(np.diff(used))) * 1e-9 if len(used) > 1 else 0.0


@dataclass
class CameraQuality:
    """
    What a camera's images were good for.

    Attributes
    ----------
    camera : str
        Its name.
    messages : int
        That were used.
    refused : int
        Messages that could not be decoded, or images of another size.
    reason : str
        Why the last of these was.
    unusable : int
        Images that show nothing: black, white, frozen or noise.
    unsettled : int
        Images without a background to compare them with.
    detections : int
        In all messages.
    moved_px : float
        By how much the camera has turned since its calibration, px; 0: it has not.

    """

    camera: str
    messages: int = 0
    refused: int = 0
    reason: str = ''
    unusable: int = 0
    unsettled: int = 0
    detections: int = 0
    moved_px: float = 0.0


def figures(quality: CameraQuality, stamps: Stamps) -> dict[str, float]:
    """Return the counts of one camera by name."""
    return {
        'messages': quality.messages,
        'detections': quality.detections,
        'late': stamps.late,
        'lost': stamps.lost(),
        'left_out': stamps.left_out,
        'added_s': stamps.added_s,
        'refused': quality.refused,
        'unusable': quality.unusable,
        'unsettled': quality.unsettled,
    }


def complaints(quality: CameraQuality, stamps: Stamps, offset_m: float) -> list[str]:
    """
    Return what a user should know of one camera, a line each.

    Parameters
    ----------
    quality : CameraQuality
        Of its images.
    stamps : Stamps
        Of its messages.
    offset_m : float
        How far its detections lie from the other cameras', m.

    """
    lines, name, lost = [], quality.camera, stamps.lost()
    if stamps.left_out_s:
        ahead_s = median(stamps.left_out_s)
        lines.append(
            f'{name}: {len(stamps.left_out_s)} messages are left out: their stamps lie '
            f'{abs(ahead_s):.3f} s {_word(ahead_s)} the other messages; set its clock'
        )
    if stamps.added_s:
        lines.append(
            f'{name}: its clock is {abs(stamps.added_s):.3f} s {_word(-stamps.added_s)} the other '
            'cameras; this is removed'
        )
    if stamps.late:
        lines.append(f'{name}: {stamps.late} messages came again or late, and are not used')
    if lost:
        lines.append(f'{name}: {lost} messages are missing in the gaps between the others')
    if quality.refused:
        lines.append(
            f'{name}: {quality.refused} messages are refused, the last since {quality.reason}'
        )
    if quality.unusable:
        lines.append(f'{name}: {quality.unusable} images are black, white, frozen or noise')
    if quality.unsettled:
        lines.append(
            f'{name}: {quality.unsettled} images could be compared with no background: nobody is '
            'seen in them'
        )
    if quality.messages and not quality.detections:
        lines.append(f'{name}: nobody is seen in any of {quality.messages} images')
    if quality.moved_px:
        lines.append(f'{name}: the camera has moved by {quality.moved_px:.1f} px: calibrate it')
    if offset_m:
        lines.append(
            f'{name}: its detections lie {offset_m:.2f} m from those of the other '
            'cameras: check its calibration'
        )
    return lines


def pace_complaint(intervals_s: Mapping[str, float], period_s: float) -> tuple[str, str] | None:
    """
    Compare the length of ticks with the interval of the fastest camera.

    Parameters
    ----------
    intervals_s : mapping of str to float
        Usual time between images by camera, s; 0: unknown.
    period_s : float
        Length of a tick, s.

    Returns
    -------
    (str, str) or None
        What differs, and what to set; None: they agree.

    """
    known = {interval: name for name, interval in intervals_s.items() if interval > 0.0}
    if not known or period_s / PACE_SLACK <= min(known) <= period_s * PACE_SLACK:
        return None
    fastest = min(known)
    what = (
        f'the fastest camera, {known[fastest]}, sends an image every {fastest:.4f} s, the period '
        f'is {period_s} s'
    )
    return what, f'set fusion.batching.period to {fastest:.4f}'


def _word(ahead_s: float) -> str:
    return 'ahead of' if ahead_s > 0 else 'behind'
