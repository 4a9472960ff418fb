"""Pages in a browser."""

from mctrack_ros.web.calibrate.pairing import Pairing, PairingError
from mctrack_ros.web.drawing import Drawing, image_drawing, plan_drawing
from mctrack_ros.web.image_source import ImageError, read_image
from mctrack_ros.web.serve.guard import check_address

__all__ = [
    'Drawing',
    'ImageError',
    'Pairing',
    'PairingError',
    'check_address',
    'image_drawing',
    'plan_drawing',
    'read_image',
]
