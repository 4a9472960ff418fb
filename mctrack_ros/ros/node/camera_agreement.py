"""Whether a camera's detections and masks can be used, on `/diagnostics`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

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
