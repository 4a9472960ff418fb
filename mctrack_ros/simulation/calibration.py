"""Calibration files of the simulated cameras: scene and transformation grids as XML."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from mctrack_ros.ground import TransformationGrid, write_grid, write_scene
from mctrack_ros.simulation import PITCH5, Camera, Scenario, Scene, scene_of

_CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
CLICK_NOISE_PX = 0.5
"""Standard deviation of a click along one axis, px."""


def write_calibration(scenario: Scenario, folder: str | Path) -> None:
    """
    Write ``scene.xml``, ``lines.yaml`` and ``<camera>.xml`` (event-tracking, Algorithms 1, 2).

    A camera that moves is calibrated in its first image.
    Each point is clicked once, with `CLICK_NOISE_PX` of noise, the same whenever it is written.

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
    if lines := scene.lines():
        rounded = [line.round(3).tolist() for line in lines]
        (folder / 'lines.yaml').write_text(yaml.safe_dump(rounded, default_flow_style=None))
    for index, camera in enumerate(scene.cameras(scenario)):
        clicks = np.random.default_rng([index, 6])
        write_grid(camera_grid(camera.at(0), scene, clicks), folder / f'{camera.name}.xml')


def camera_grid(
    camera: Camera, scene: Scene = PITCH5, clicks: np.random.Generator | None = None
) -> TransformationGrid:
    """
    Return the cells of a scene's grid whose four corners are in the camera's image.

    Parameters
    ----------
    camera : Camera
        The camera.
    scene : Scene
        Whose grid.
    clicks : Generator, optional
        Draws the noise of the clicks; unless given, they are exact to 0.01 px.

    """
    extent, side = np.array(scene.extent_m), scene.cell_m
    columns, rows = (extent // side).astype(int).tolist()
    cells = np.stack(np.meshgrid(np.arange(columns), np.arange(rows), indexing='ij'), -1)
    corners = cells.reshape(-1, 1, 2) + _CORNERS
    origin = (extent - side * np.array([columns, rows])) / 2
    ground = origin + side * corners
    world = np.concatenate([ground, np.zeros((*ground.shape[:2], 1))], axis=2)
    seen = camera.sees(world).all(axis=1)
    image = camera.project(world[seen])
    if clicks is not None:
        noise = clicks.normal(scale=CLICK_NOISE_PX, size=(columns + 1, rows + 1, 2))
        image = image + noise[tuple(np.moveaxis(corners[seen], -1, 0))]
    names = tuple(tuple(f'{x}-{y}' for x, y in cell) for cell in corners[seen].tolist())
    return TransformationGrid(
        camera.name, names, ground[seen], np.round(image, 2), image_size=camera.size
    )
