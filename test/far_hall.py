"""The drawn hall where its calibrations are stated in coordinates far from zero."""

import numpy as np
import yaml

from drawn_hall import SIZE, VIEWS, projection
from mctrack_ros.ground import (
    ProjectiveMapping,
    grid_from_points,
    write_calibration,
    write_grid,
)
from mctrack_ros.site.site import load_site

AREA = np.array([[-6.0, -6.0], [6.0, 6.0]])


def write_far_hall(folder, offset, **content):
    """Write the hall's site, one camera by a clicked grid, the other by its pose; return it."""
    folder.mkdir(exist_ok=True)
    axis = np.arange(-8.0, 9.0, 4.0)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    names = [f'p{index}' for index in range(len(points))]
    north, south = (ProjectiveMapping(projection(VIEWS[name]), SIZE) for name in sorted(VIEWS))
    noise = np.random.default_rng(8).normal(0, 0.3, points.shape)
    clicks = north.image_from_ground(points) + noise
    write_grid(grid_from_points('north', names, points + offset, clicks)[0], folder / 'north.xml')
    write_calibration(south.moved(offset), folder / 'south.yaml', 'camera_info', 'south')
    size = {'image_width': SIZE[0], 'image_height': SIZE[1]}
    site = {
        'name': 'hall',
        'area': ','.join(f'{value:.15g}' for value in (AREA + offset).ravel()),
        'cameras': {
            'north': {'grid': 'north.xml', **size},
            'south': {'calibration': 'south.yaml', **size},
        },
    }
    (folder / 'site.yaml').write_text(yaml.safe_dump(site | content))
    return load_site(folder / 'site.yaml')
