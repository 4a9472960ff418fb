"""Whether a camera's detections, masks and clock can be used, on `/diagnostics`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from mctrack_ros.fusion.camera_clocks import CameraClocks, Jump
from mctrack_ros.fusion.sensor_bias.camera_bias import LEAST_CAMERAS, CameraBias


@dataclass(frozen=True, slots=True)
class Agreement:
    """
    How one camera agrees with the others.

    Attributes
    ----------
    bias : CameraBias
        Of all cameras; it changes while they are tracked with.
    index : int
        The camera's, in the site's order.

    """

    bias: CameraBias
    index: int

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state; a camera that is corrected or weighed down is a warning."""
        right, up = self.bias.offset[self.index].tolist()
        scatter = float(np.sqrt(self.bias.variance[self.index]))
        distance = float(np.hypot(right, up))
        values = {
            'offset x [m]': f'{right:.2f}',
            'offset y [m]': f'{up:.2f}',
            'added noise [m]': f'{scatter:.2f}',
            'comparisons': str(self.bias.comparisons(self.index)),
        }
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if distance or scatter else DiagnosticStatus.OK,
            name=name,
            message=_message(distance, scatter),
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )


def agreements(cameras: Sequence[str], bias: CameraBias | None) -> dict[str, Agreement]:
    """Return the health of each camera; nothing where no bias is estimated, or of too few."""
    if bias is None or len(cameras) < LEAST_CAMERAS:
        return {}
    return {f'{camera} agreement': Agreement(bias, row) for row, camera in enumerate(cameras)}


def _message(distance: float, scatter: float) -> str:
    if distance:
        return (
            f"its detections lie {distance:.2f} m from the other cameras': check its calibration"
        )
    if scatter:
        return (
            f'its detections scatter by {scatter:.2f} m more than it says: check its calibration'
        )
    return 'its detections lie where those of the other cameras do'


@dataclass(frozen=True, slots=True)
class ClockAgreement:
    """
    How one camera's clock agrees with the others'.

    Attributes
    ----------
    clocks : CameraClocks
        Of all cameras; it changes with every message.
    camera : str
        The camera's name.

    """

    clocks: CameraClocks
    camera: str

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: a corrected clock is a warning, one left out an error."""
        offset_s, added_s = self.clocks.offset_s(self.camera), self.clocks.added_s(self.camera)
        level, message = DiagnosticStatus.OK, 'its clock agrees with those of the other cameras'
        if added_s:
            level, message = DiagnosticStatus.WARN, clock_message(offset_s) + ': this is removed'
        if self.clocks.is_left_out(self.camera):
            level = DiagnosticStatus.ERROR
            message = clock_message(offset_s) + ': the camera is left out until that is mended'
        values = {'offset [s]': f'{offset_s:.3f}', 'added to its stamps [s]': f'{added_s:.3f}'}
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )


@dataclass(slots=True)
class ClockJumps:
    """
    Whether the clocks of all cameras have jumped at once.

    Attributes
    ----------
    clocks : CameraClocks
        Of all cameras; it changes with every message.
    reported : Jump or None
        The last that was reported.

    """

    clocks: CameraClocks
    reported: Jump | None = None

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: a jump since the last report is a warning."""
        jump, level = self.clocks.jump, DiagnosticStatus.OK
        if jump is not self.reported:
            self.reported, level = jump, DiagnosticStatus.WARN
        message = f'{jump}' if jump else "all cameras' clocks go on evenly"
        return DiagnosticStatus(level=level, name=name, message=message)


@dataclass(slots=True)
class MaskHealth:
    """
    Whether a camera's foreground masks are used.

    Attributes
    ----------
    reason : str
        Why they are left out; empty: they are used.

    """

    reason: str = ''

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: masks that are left out are a warning."""
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if self.reason else DiagnosticStatus.OK,
            name=name,
            message=f'its masks are left out: {self.reason}' if self.reason else 'they are used',
        )


def clock_message(offset_s: float) -> str:
    """Say how a camera's stamps differ from the others'."""
    word = 'ahead of' if offset_s > 0 else 'behind'
    return f"its stamps lie {abs(offset_s):.3f} s {word} the other cameras'"
