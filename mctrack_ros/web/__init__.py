"""Pages in a browser."""

from mctrack_ros.streams.serve.access import check_address
from mctrack_ros.web.calibrate.pairing import Pairing, PairingError
from mctrack_ros.web.drawing import Drawing, image_drawing, plan_drawing
from mctrack_ros.web.image_source import ImageError, read_image

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
