"""A camera of the simulated pitch, the points of an 8 m grid that it sees, and its image."""

import cv2
import numpy as np

from mctrack_ros.simulation import Scenario, pitch5_cameras
from mctrack_ros.simulation.calibration import camera_grid
from mctrack_ros.simulation.pitch.stadium import empty_image
from mctrack_ros.web import Pairing

CAMERA = pitch5_cameras(Scenario())[0]


def seen_points():
    """Return metres and pixels by name of the grid points in the image."""
    grid = camera_grid(CAMERA)
    names = [name for cell in grid.names for name in cell]
    return (
        dict(zip(names, map(tuple, grid.ground.reshape(-1, 2).tolist()))),
        dict(zip(names, map(tuple, grid.image.reshape(-1, 2).tolist()))),
    )


def block(columns=4, rows=3, first=(1, 3)):
    """Return the names of a block of grid points, all in the image."""
    left, low = first
    return [f'{left + i}-{low + j}' for i in range(columns) for j in range(rows)]


def paired(names, pixels=None):
    """Return a pairing with some points in their places."""
    ground, image = seen_points()
    pairing = Pairing('cam1', ground, CAMERA.size)
    for name in names:
        pairing.choose(name)
        pairing.place(*(pixels or image)[name])
    return pairing


def write_scene_and_image(folder):
    """Write scene.xml and cam1.png."""
    ground, _ = seen_points()
    points = [f'  <point name="{name}" x="{x!r}" y="{y!r}"/>' for name, (x, y) in ground.items()]
    lines = ['<?xml version="1.0" encoding="utf-8"?>', '<scene>', *points, '</scene>']
    (folder / 'scene.xml').write_text('\n'.join(lines) + '\n')
    image = empty_image(CAMERA, np.random.default_rng(1))
    cv2.imwrite(str(folder / 'cam1.png'), image)
