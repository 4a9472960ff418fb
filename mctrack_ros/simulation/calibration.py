"""Calibration files of the simulated cameras: scene and transformation grids as XML."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mctrack_ros.ground import TransformationGrid, write_grid, write_scene
from mctrack_ros.simulation import PITCH5, Camera, Scenario, Scene, scene_of

_CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])


def write_calibration(scenario: Scenario, folder: str | Path) -> None:
    """
    Write ``scene.xml`` and one ``<camera>.xml`` a camera (event-tracking, Algorithms 1 and 2).

    Parameters
    ----------
    scenario : Scenario
        Says which scene, the size of the images and the lenses.
    folder : str or Path
        Made where it is missing; files in it are replaced.

    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    scene = scene_of(scenario)
    write_scene(dict(scene.landmarks()), folder / 'scene.xml')
    for camera in scene.cameras(scenario):
        write_grid(camera_grid(camera, scene), folder / f'{camera.name}.xml')


def camera_grid(camera: Camera, scene: Scene = PITCH5) -> TransformationGrid:
    """Return the cells of a scene's grid whose four corners are in the camera's image."""
    extent, side = np.array(scene.extent_m), scene.cell_m
    columns, rows = (extent // side).astype(int).tolist()
    cells = np.stack(np.meshgrid(np.arange(columns), np.arange(rows), indexing='ij'), -1)
    corners = cells.reshape(-1, 1, 2) + _CORNERS
    origin = (extent - side * np.array([columns, rows])) / 2
    ground = origin + side * corners
    world = np.concatenate([ground, np.zeros((*ground.shape[:2], 1))], axis=2)
    seen = camera.sees(world).all(axis=1)
    image = np.round(camera.project(world[seen]), 2)
    names = tuple(tuple(f'{x}-{y}' for x, y in cell) for cell in corners[seen].tolist())
    return TransformationGrid(camera.name, names, ground[seen], image, image_size=camera.size)
