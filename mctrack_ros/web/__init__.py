"""Pages in a browser."""

from mctrack_ros.web.drawing import Drawing, picture_drawing, plan_drawing
from mctrack_ros.web.guard import check_address
from mctrack_ros.web.pairing import Pairing, PairingError
from mctrack_ros.web.picture_source import PictureError, read_picture

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
