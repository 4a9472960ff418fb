"""How well real calibrations put feet where people stood: PETS view 1, WILDTRACK, lab6p."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from mctrack_experiments.datasets import lab6p, wildtrack
from mctrack_experiments.datasets.social_pose import read_homography
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import FitError, GroundMapping, fit_camera, read_calibration

Floats = NDArray[np.float64]
PETS_SIZE = (768, 576)
CLICKS = (4, 3)
CLICK_NOISE_PX = 1.0
SEEDS = 20


def reproduce_cameras(data: Path) -> Figures:
    """
    Map annotated feet of three data sets to metres and compare with the annotated positions.

    Parameters
    ----------
    data : Path
        Folder of the real data.

    """
    mapping, feet, truth = pets_view1(data / 'pets2009_s2l1')
    figures = {'pets.view1.median_m': _median_error(mapping, feet, truth)}
    clicked = [_clicked_error(mapping, feet, truth, seed) for seed in range(SEEDS)]
    figures['pets.clicked12.median_m'] = float(np.median(clicked))
    figures['pets.clicked12.worst_seed_m'] = float(np.max(clicked))
    for name, error in wildtrack_errors(data / 'wildtrack'):
        figures[f'wildtrack.{name}.median_m'] = error
    figures['wildtrack.worst_median_m'] = max(
        value for name, value in figures.items() if name.startswith('wildtrack.')
    )
    figures['lab6p.largest_m'] = lab6p_error(data / 'epfl_lab6p')
    protocol = {
        'pets': 'view 1, box feet (left + w/2 - 1, top + h - 1) of all truth but confidence 0, '
        'through View_001.xml (Tsai)',
        'clicked': f'{CLICKS[0] * CLICKS[1]} points of a lattice over the walked area, '
        f'{CLICK_NOISE_PX:g} px noise, {SEEDS} seeds, camera fitted, feet of the same truth',
        'wildtrack': '7 cameras, 360 frames, lower edge of the boxes that end in the image; '
        'whole pixels are taken at their middle (+ 0.5 px; without, the worst is 0.124 m)',
        'lab6p': 'annotated feet of 4 cameras, largest difference from the stored positions',
    }
    return Figures('cameras', 'mctrack reproduce cameras', protocol, figures)


def pets_view1(folder: Path) -> tuple[GroundMapping, Floats, Floats]:
    """Return view 1's mapping, the annotated feet, (n, 2) px, and positions, (n, 2) m."""
    mapping = read_calibration(folder / 'calibration' / 'View_001.xml', PETS_SIZE)
    table = np.loadtxt(folder / 'gt' / '3DMOT2015_PETS09-S2L1_gt.txt', delimiter=',')
    table = table[table[:, 6] != 0]
    left, top, width, height = table[:, 2:6].T
    return mapping, np.column_stack([left + width / 2 - 1, top + height - 1]), table[:, 7:9]


def wildtrack_errors(folder: Path) -> Iterator[tuple[str, float]]:
    """Yield each camera's name and median error, m."""
    seen: list[list[tuple[float, float, int]]] = [[] for _ in wildtrack.CAMERAS]
    for _, camera, column, row, position_id in wildtrack.annotated_feet(folder):
        seen[camera].append((column, row, position_id))
    for index, rows in enumerate(seen):
        table = np.array(rows)
        truth = wildtrack.position_of(table[:, 2].astype(np.int64))
        mapping = wildtrack.read_mapping(folder, index)
        yield wildtrack.CAMERAS[index], _median_error(mapping, table[:, :2], truth)


def lab6p_error(folder: Path) -> float:
    """Return the largest difference from the stored positions of the annotated feet, m."""
    largest = 0.0
    for camera in lab6p.CAMERAS:
        mapping = read_homography(folder / 'Calibration' / f'{camera}.mat', lab6p.IMAGE_SIZE)
        stored = loadmat(folder / 'Annotation' / f'{camera}.mat')
        pixel, place = (
            np.concatenate(
                [np.asarray(each, np.float64).reshape(-1, 2) for each in stored[key][0]]
            )
            for key in ('gp_uv_true', 'gp_xy_true')
        )
        known = np.isfinite(pixel).all(axis=1)
        away = np.abs(mapping.ground_from_image(pixel[known]) - place[known])
        largest = max(largest, float(away.max()))
    return largest


def _clicked_error(mapping: GroundMapping, feet: Floats, truth: Floats, seed: int) -> float:
    """Return the median error, m, of the camera fitted to a dozen clicks; infinite if refused."""
    low, high = np.percentile(truth, [2, 98], axis=0)
    axes = [np.linspace(a, b, count) for a, b, count in zip(low, high, CLICKS)]
    ground = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    noise = np.random.default_rng(seed).normal(0, CLICK_NOISE_PX, (len(ground), 2))
    try:
        clicked = mapping.image_from_ground(ground) + noise
        fit = fit_camera(ground, clicked, PETS_SIZE, CLICK_NOISE_PX)
    except FitError:
        return float('inf')
    return _median_error(fit.mapping, feet, truth)


def _median_error(mapping: GroundMapping, feet: Floats, truth: Floats) -> float:
    return float(np.median(np.linalg.norm(mapping.ground_from_image(feet) - truth, axis=1)))
