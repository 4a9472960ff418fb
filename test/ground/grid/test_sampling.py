"""A grid sampled from a camera covers what the camera sees well."""

import numpy as np
import pytest

from lens_cameras import SIZE, camera
from mctrack_ros.ground.camera.lens import image_samples
from mctrack_ros.ground.grid.sampling import (
    FEWEST_CELLS,
    PERSON_M,
    SMALLEST_SHARE,
    SPACINGS_M,
    sampled_grid,
)


def cells(mapping, spacing):
    """Return the ground corners of all squares that are seen where people look tall enough."""
    pixel = image_samples(SIZE)
    ground = mapping.ground_from_image(pixel[~mapping.is_extrapolated(pixel)])
    tall = np.abs(mapping.height_px(ground, PERSON_M))
    ground = ground[tall >= SMALLEST_SHARE * np.nanmax(tall)]
    low, high = ground.min(axis=0), ground.max(axis=0)
    found = set()
    for place in np.ndindex(*np.ceil((high - low) / spacing + 1).astype(int)):
        first = np.floor(low / spacing) + place
        corners = spacing * np.add(first, [[0, 0], [1, 0], [1, 1], [0, 1]])
        if ((corners >= low) & (corners <= high)).all():
            pixel = mapping.image_from_ground(corners)
            if ((pixel >= 0) & (pixel <= SIZE)).all():
                found.add(tuple(sorted(map(tuple, np.round(corners, 6).tolist()))))
    return found


@pytest.mark.parametrize(
    'mapping', [camera(), camera(eye=(0.0, -6.0, 3.0), target=(0.5, 0.0, 0.0), focal=500.0)]
)
def test_a_sampled_grid_has_all_cells_that_are_seen_and_no_wider_one_has_a_dozen(mapping):
    grid = sampled_grid(mapping, 'north')
    given = {tuple(sorted(map(tuple, cell))) for cell in grid.ground.tolist()}
    spacing = float(np.ptp(grid.ground[0], axis=0)[0])
    assert given == cells(mapping, spacing)
    assert len(given) >= FEWEST_CELLS
    wider = SPACINGS_M[SPACINGS_M.index(spacing) - 1]
    assert len(cells(mapping, wider)) < FEWEST_CELLS
    np.testing.assert_allclose(
        grid.image.reshape(-1, 2), mapping.image_from_ground(grid.ground.reshape(-1, 2))
    )
    assert grid.image_size == SIZE
    assert grid.names[0][0] == '{:.0f}:{:.0f}'.format(*grid.ground[0, 0] / spacing)
