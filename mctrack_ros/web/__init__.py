"""Pages in a browser."""

from mctrack_ros.web.calibrate.pairing import Pairing, PairingError
from mctrack_ros.web.drawing import Drawing, picture_drawing, plan_drawing
from mctrack_ros.web.picture_source import PictureError, read_picture
from mctrack_ros.web.serve.guard import check_address

__all__ = [
    'Drawing',
    'Pairing',
    'PairingError',
    'PictureError',
    'check_address',
    'picture_drawing',
    'plan_drawing',
    'read_picture',
]
