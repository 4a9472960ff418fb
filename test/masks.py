"""Three small cameras around a square, and the masks of people in it."""

import numpy as np

from drawn_hall import SIZE, projection
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Foreground

POSITIONS = {'east': (9.0, 0.0, 4.0), 'north': (0.0, 9.0, 4.0), 'south': (0.5, -9.0, 4.0)}
MAPPINGS = {name: ProjectiveMapping(projection(at), SIZE) for name, at in POSITIONS.items()}
AREA = '-2,-2,2,2'
SHAPE = (60, 80)
"""Height and width of a mask, px: a quarter of an image."""


def mask_of(mapping, people, shape=SHAPE):
    """Return the mask of people, (n, 2) m, each a box of .5 x 1.8 m, with drawing of its own."""
    mask = np.zeros(shape, np.uint8)
    if len(people):
        scale = shape[1] / SIZE[0]
        foot = mapping.image_from_ground(people) * scale
        head = mapping.image_from_ground(people, 1.8) * scale
        half = mapping.width_px(people, 0.25) * scale
        for (x, bottom), top, wide in zip(foot, head[:, 1], half):
            rows = slice(max(round(top), 0), max(round(bottom), 0))
            mask[rows, max(round(x - wide), 0) : max(round(x + wide), 0)] = 255
    return mask


def foreground_of(name, people, stamp_ns):
    """Return what a camera tells of people."""
    return Foreground(stamp_ns, mask_of(MAPPINGS[name], np.reshape(people, (-1, 2))))
