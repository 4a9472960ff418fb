"""Health of a camera: whether it moved, and whether its images show anything."""

from __future__ import annotations

from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from mctrack_ros.perception import CameraShift, ImageState, ShiftState

_POSE_MESSAGES = {
    ShiftState.SETTLING: 'learning where the image lies',
    ShiftState.STILL: 'the camera has not moved',
    ShiftState.MOVED: 'the camera has moved: calibrate it anew',
    ShiftState.UNKNOWN: 'what the camera saw at the start is not found again',
}


@dataclass(slots=True)
class PoseHealth:
    """
    Whether the camera still stands as it was calibrated.

    Attributes
    ----------
    shift : CameraShift
        What is known of its shift.

    """

    shift: CameraShift = field(default_factory=CameraShift)

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state; a camera that has moved, or may have, is a warning."""
        shift = self.shift
        values = {
            'shift [px]': f'{shift.size_px:.2f}',
            'shift right [px]': f'{shift.right_px:.2f}',
            'shift down [px]': f'{shift.down_px:.2f}',
            'turn [deg]': f'{shift.turn_deg:.3f}',
            'added noise [px]': f'{shift.noise_px:.2f}',
            'patches': str(shift.patches),
        }
        doubtful = shift.state in (ShiftState.MOVED, ShiftState.UNKNOWN)
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if doubtful else DiagnosticStatus.OK,
            name=name,
            message=_POSE_MESSAGES[shift.state],
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )


_IMAGE_MESSAGES = {
    ImageState.USABLE: 'the images show something',
    ImageState.BLANK: 'the images are black or white',
    ImageState.FROZEN: 'the image stays the same to the last pixel',
    ImageState.NOISE: 'the images are nothing but noise',
}


_UNSETTLED = 'the background is learned: nobody is seen meanwhile'


@dataclass(slots=True)
class ImageHealth:
    """
    Whether a camera's images show anything.

    Attributes
    ----------
    state : ImageState
        Of the last image.
    is_settled : bool
        Whether it could be compared with a background.

    """

    state: ImageState = ImageState.USABLE
    is_settled: bool = True

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state; what cannot be used is an error, an unsettled view a warning."""
        usable = self.state is ImageState.USABLE
        level = DiagnosticStatus.OK if usable else DiagnosticStatus.ERROR
        message = _IMAGE_MESSAGES[self.state]
        if usable and not self.is_settled:
            level, message = DiagnosticStatus.WARN, _UNSETTLED
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key='state', value=str(self.state))],
        )
