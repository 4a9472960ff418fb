"""Experiments I and II of the event-tracking paper: how exact image-to-ground mappings are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import (
    Camera,
    CameraMapping,
    FitError,
    GridError,
    GroundMapping,
    LensPrior,
    ProjectiveMapping,
    fit_camera,
    grid_from_points,
)
from mctrack_ros.ground.grid.cells import CellMapping, Cells
from mctrack_ros.ground.grid.iterated import IteratedMapping

Floats = NDArray[np.float64]
IMAGE_SIZE = (720, 576)
PITCH_M = (105.0, 68.0)
SPACINGS_M = (8, 16, 24, 32, 40)
PATH_POINTS = 40
CLICK_NOISE_PX = 0.5
SEEDS = 20
TABLE_K1 = -0.2
LENS_BOUNDS = {
    'across_px': 20.0, 'down_px': 20.0, 'aspect': 0.01, 'k2': 0.05, 'p1': 0.001, 'p2': 0.001,
    'k3': 0.02, 'k4': 0.05,
}  # fmt: skip
"""How far lenses deviate, drawn evenly: principal point from the middle, aspect ratio from 1, and
terms of OpenCV's. The fitted camera has no k4: none of them is of its family."""
EYE_M, TARGET_M, FOCAL_PX = (52.5, -20.0, 35.0), (52.5, 34.0, 0.0), 600.0
PATHS_M = {
    'path1': ((36.0, 7.0), (69.0, 7.0)),
    'path2': ((24.0, 33.0), (81.0, 33.0)),
    'path3': ((14.0, 61.0), (91.0, 61.0)),
    'path4': ((54.0, 4.0), (54.0, 64.0)),
    'path5': ((26.0, 30.0), (26.0, 64.0)),
}
"""Ends of the five paths: across near, middle and far; away in the middle and at the edge."""
PAPER_M = {
    'iterated': [(0.59, 0.65), (0.51, 0.57), (0.60, 0.67), (0.31, 0.28), (1.02, 0.98)],
    'plane1': [(29.77, 33.03), (13.53, 15.28), (28.81, 25.11), (19.13, 18.64), (31.35, 35.21)],
    'plane2': [(12.95, 13.48), (14.69, 15.49), (11.73, 13.22), (10.75, 9.61), (15.02, 13.84)],
}
"""RMSE in x and y of each path as the paper's Table 3 prints them."""


def true_camera(k1: float) -> Camera:
    """Return the camera of the experiments: over the middle of the pitch, 35 m up."""
    return looking(np.array(EYE_M), np.array(TARGET_M), FOCAL_PX, k1)


def drawn_lens(random: np.random.Generator) -> dict[str, float]:
    """Return by how much a lens deviates, drawn evenly within `LENS_BOUNDS`."""
    return {name: random.uniform(-bound, bound) for name, bound in LENS_BOUNDS.items()}


def with_lens(camera: Camera, lens: Mapping[str, float]) -> Camera:
    """Return a camera whose lens deviates so, by the names of `LENS_BOUNDS`; others by nothing."""
    off = {name: lens.get(name, 0.0) for name in LENS_BOUNDS}
    focal = camera.intrinsics[0]
    moved = np.array([0, focal * off['aspect'], off['across_px'], off['down_px']])
    terms = [camera.distortion[0], *(off[name] for name in ('k2', 'p1', 'p2', 'k3', 'k4')), 0, 0]
    return replace(camera, intrinsics=camera.intrinsics + moved, distortion=np.array(terms))


def looking(eye: Floats, target: Floats, focal_px: float, k1: float) -> Camera:
    """Return a camera at one place, (3,) m, that looks at another."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.array([right, np.cross(forward, right), forward])
    intrinsics = np.array([focal_px, focal_px, IMAGE_SIZE[0] / 2, IMAGE_SIZE[1] / 2])
    return Camera(intrinsics, np.array([k1, 0, 0, 0, 0]), rotation, -rotation @ eye)


def visible_grid(camera: CameraMapping, spacing_m: float) -> Floats:
    """
    Return the grid points, (n, 2) m, on the pitch that the camera sees.

    The grid is centred on the pitch, with an even or an odd number of points along each side:
    whichever gives most whole cells in the image, then most points.
    """
    offers = []
    for across in _centred(PITCH_M[0], spacing_m):
        for along in _centred(PITCH_M[1], spacing_m):
            points = np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2)
            seen = camera.image_from_ground(points)
            inside = (seen >= 0).all(axis=1) & (seen < IMAGE_SIZE).all(axis=1)
            offers.append(points[inside])
    return max(offers, key=lambda points: (_cell_count(points), len(points)))


def _centred(length: float, spacing_m: float) -> list[NDArray[np.floating]]:
    most = int(length // spacing_m) + 1
    return [
        length / 2 + spacing_m * (np.arange(count) - (count - 1) / 2)
        for count in (most, most - 1)
        if count >= 2
    ]


def path_points() -> dict[str, Floats]:
    """Return the points of the five paths, (40, 2) m each."""
    share = np.linspace(0, 1, PATH_POINTS)[:, None]
    return {
        name: np.array(start) + share * (np.array(end) - np.array(start))
        for name, (start, end) in PATHS_M.items()
    }


Maker = Callable[[Floats, Floats], GroundMapping]


def makers(grid: Floats) -> dict[str, Maker]:
    """Return what makes each method's mapping from grid points, m, and their clicks, px."""
    planes = {'plane1': _plane(grid, 1.0), 'plane2': _plane(grid, 0.5)}
    return {
        'fitted': lambda ground, image: fit_camera(ground, image, IMAGE_SIZE).mapping,
        'cell': lambda ground, image: CellMapping(
            _cells(ground, image), IMAGE_SIZE, CLICK_NOISE_PX
        ),
        'iterated': lambda ground, image: IteratedMapping(_cells(ground, image), IMAGE_SIZE),
        'iterated_exact': lambda ground, image: IteratedMapping(
            _cells(ground, image), IMAGE_SIZE, threshold_px=0.0
        ),
        'homography': lambda ground, image: ProjectiveMapping.from_points(
            ground, image, IMAGE_SIZE
        ),
    } | {
        name: lambda ground, image, corners=corners: IteratedMapping(
            Cells(ground[None, corners], image[None, corners]), IMAGE_SIZE, threshold_px=0.0
        )
        for name, corners in planes.items()
        if corners is not None
    }


def _cells(ground: Floats, image: Floats) -> Cells:
    names = [f'{x:g}-{y:g}' for x, y in ground]
    return Cells.of(grid_from_points('camera', names, ground, image)[0])


def _cell_count(points: Floats) -> int:
    """Return how many whole cells the points of a grid, m, make."""
    try:
        return len(_cells(points, points))
    except GridError:
        return 0


def _plane(grid: Floats, share: float) -> list[int] | None:
    """Return the corners, least x and y first, of the largest rectangle in a part of a grid."""
    middle = (grid.min(axis=0) + grid.max(axis=0)) / 2
    half = share * (grid.max(axis=0) - grid.min(axis=0)) / 2 + 1e-6
    near = {tuple(p) for p in grid[(np.abs(grid - middle) <= half).all(axis=1)].round(6).tolist()}
    offers = []
    for x0, y0 in near:
        for x1, y1 in near:
            corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
            if x1 > x0 and y1 > y0 and near >= set(corners):
                offers.append(((x1 - x0) * (y1 - y0), corners))
    if not offers:
        return None
    at = {tuple(place): index for index, place in enumerate(grid.round(6).tolist())}
    return [at[corner] for corner in max(offers)[1]]


def measure(
    spacing_m: float, k1: float, noise_px: float, seeds: int, is_drawn: bool = False
) -> dict[str, float]:
    """
    Return RMSE by dotted name: method, path and axis; the fitted camera's beside its bound.

    Parameters
    ----------
    spacing_m : float
        Between neighbouring grid points, m.
    k1 : float
        First radial coefficient of the lens.
    noise_px : float
        Standard deviation of a click along one axis, px.
    seeds : int
        How often the grid is clicked.
    is_drawn : bool
        Whether the lens is another one each time, as `drawn_lens` draws it.

    """
    trials = [_Trial.of(seed, spacing_m, k1, noise_px, is_drawn) for seed in range(seeds)]
    paths = path_points()
    where = np.concatenate(list(paths.values()))
    figures: dict[str, float] = {'points': len(trials[0].grid)}
    found: dict[str, Floats] = {}
    made = [makers(each.grid) for each in trials]
    for name in made[0]:
        try:
            maps = [make[name](each.grid, each.clicks) for make, each in zip(made, trials)]
        except (FitError, GridError):
            figures[f'{name}.refused'] = 1
            continue
        seen = [each.camera.image_from_ground(where) for each in trials]
        found[name] = np.array([each.ground_from_image(pixel) for each, pixel in zip(maps, seen)])
        figures |= {
            f'{name}.{key}_m': value
            for key, value in _by_path(_rms(found[name] - where), paths).items()
        }
        figures[f'{name}.rmse_max_m'] = _worst(found[name] - where, paths)
        figures[f'{name}.extrapolated'] = float(maps[0].is_extrapolated(seen[0]).mean())
    if 'iterated' in found:
        figures['iterated.by_ratio_max_m'] = _worst(found['iterated_exact'] - found['cell'], paths)
        figures['iterated.by_stop_max_m'] = _worst(
            found['iterated'] - found['iterated_exact'], paths
        )
    if 'fitted' in found and noise_px:
        least = np.mean([_bound(each.camera, each.grid, where, noise_px) for each in trials], 0)
        figures |= _efficiency(_rms(found['fitted'] - where), least, paths)
    return figures


@dataclass(frozen=True, eq=False, slots=True)
class _Trial:
    """A camera, the grid points that it sees, (n, 2) m, and their clicks, px."""

    camera: CameraMapping
    grid: Floats
    clicks: Floats

    @classmethod
    def of(cls, seed: int, spacing_m: float, k1: float, noise_px: float, is_drawn: bool) -> _Trial:
        random = np.random.default_rng(seed)
        lens = drawn_lens(np.random.default_rng((seed, 1))) if is_drawn else {}
        camera = CameraMapping(with_lens(true_camera(k1), lens), IMAGE_SIZE)
        grid = visible_grid(camera, spacing_m)
        noise = random.normal(0.0, noise_px, grid.shape)
        return cls(camera, grid, camera.image_from_ground(grid) + noise)


def _rms(errors: Floats) -> Floats:
    """Return the root mean squares over seeds, (points, 2)."""
    rms: Floats = np.sqrt(np.mean(np.square(errors), axis=0))
    return rms


def _worst(errors: Floats, paths: dict[str, Floats]) -> float:
    """Return the largest RMSE of a path and axis, m."""
    return max(_by_path(_rms(errors), paths).values())


def _efficiency(rms: Floats, least: Floats, paths: dict[str, Floats]) -> dict[str, float]:
    """Return RMSE over the Cramer-Rao bound: the worse axis over all paths, the worst path."""
    whole = np.sqrt((rms**2).mean(axis=0) / least.mean(axis=0))
    rmse, bound = _by_path(rms, paths), _by_path(np.sqrt(least), paths)
    return {
        'fitted.crb_ratio_max': float(whole.max()),
        'fitted.crb_ratio_of_a_path_max': max(rmse[key] / bound[key] for key in rmse),
    }


def _by_path(deviation: Floats, paths: dict[str, Floats]) -> dict[str, float]:
    """Return root mean squares, by path and axis, of (points, 2) root mean squares."""
    parts = np.split(deviation, np.cumsum([len(points) for points in paths.values()])[:-1])
    return {
        f'{name}.rmse_{axis}': float(np.sqrt(np.mean(np.square(part[:, index]))))
        for name, part in zip(paths, parts)
        for index, axis in enumerate('xy')
    }


def _bound(camera: CameraMapping, grid: Floats, where: Floats, noise_px: float) -> Floats:
    """Return the Bayesian Cramer-Rao bound, (n, 2) m², of positions by a fitted camera."""
    clicked = camera.parameter_jacobian(grid)
    usual = LensPrior(camera.image_size).slopes(camera.camera.intrinsics[0])
    slopes = np.concatenate([clicked.reshape(-1, usual.shape[1]) / noise_px, usual])
    scale = 1 / np.linalg.norm(slopes, axis=0)
    information = (slopes * scale).T @ (slopes * scale)
    covariance = np.linalg.inv(information) * scale[:, None] * scale
    by_camera = camera.parameter_jacobian(where)
    image = by_camera @ covariance @ by_camera.swapaxes(1, 2)
    inverse = np.linalg.inv(camera.image_jacobian(where))
    ground = inverse @ image @ inverse.swapaxes(1, 2)
    return np.asarray(np.einsum('nii->ni', ground))


def reproduce_table3() -> Figures:
    """Measure Experiment I: five paths, grid points 8 m apart, and wider for the fitted camera."""
    figures: dict[str, float] = {}
    for spacing in SPACINGS_M:
        measured = measure(spacing, TABLE_K1, CLICK_NOISE_PX, SEEDS, is_drawn=True)
        prefix = '' if spacing == SPACINGS_M[0] else f'grid{spacing}.'
        for name, value in measured.items():
            method, _, rest = name.partition('.')
            figures[f'{method}.{prefix}{rest}' if rest else f'{prefix}{name}'] = value
    for name in ('fitted.crb_ratio_max', 'fitted.crb_ratio_of_a_path_max'):
        last = name.partition('.')[2]
        figures[name] = max(value for key, value in figures.items() if key.endswith(last))
    clean = measure(SPACINGS_M[0], 0.0, 0.0, 1)
    figures |= {f'clean.{name}': value for name, value in clean.items() if 'rmse_max' in name}
    figures |= {
        f'paper.{method}.path{index}.rmse_{axis}_m': value
        for method, rows in PAPER_M.items()
        for index, row in enumerate(rows, 1)
        for axis, value in zip('xy', row)
    }
    protocol = _protocol(TABLE_K1) | {
        'lens': f'another one each seed, drawn evenly up to {LENS_BOUNDS} off: the principal '
        "point from the middle, the aspect ratio from 1, and OpenCV's terms; the fitted camera "
        'has no k4',
    }
    return Figures('table3', 'mctrack reproduce table3', protocol, figures)


def reproduce_fig18() -> Figures:
    """Measure Experiment II: all spacings, with and without distortion and clicking noise."""
    figures: dict[str, float] = {}
    for k1 in (0.0, TABLE_K1):
        for noise_px in (0.0, CLICK_NOISE_PX):
            name = f'{"distorted" if k1 else "straight"}.{"clicked" if noise_px else "exact"}'
            for spacing in SPACINGS_M:
                measured = measure(spacing, k1, noise_px, SEEDS if noise_px else 1)
                figures |= {
                    f'{name}.grid{spacing}.{key}': value
                    for key, value in measured.items()
                    if key.endswith(('rmse_max_m', 'refused', 'extrapolated'))
                }
    return Figures('fig18', 'mctrack reproduce fig18', _protocol(TABLE_K1), figures)


def _refusals(k1: float) -> dict[str, str]:
    """Return why methods refuse the points of a spacing, exactly clicked."""
    camera, reasons = CameraMapping(true_camera(k1), IMAGE_SIZE), {}
    for spacing in SPACINGS_M:
        grid = visible_grid(camera, spacing)
        for name, make in makers(grid).items():
            try:
                make(grid, camera.image_from_ground(grid))
            except (FitError, GridError) as error:
                reasons[f'{name}.grid{spacing}'] = str(error)
    return reasons


def _protocol(k1: float) -> dict[str, object]:
    return {
        'image_size_px': list(IMAGE_SIZE),
        'camera': f'at {EYE_M} m, looking at {TARGET_M} m, focal length {FOCAL_PX:g} px',
        'k1': k1,
        'click_noise_px': CLICK_NOISE_PX,
        'seeds': SEEDS,
        'paths_m': {name: [list(end) for end in ends] for name, ends in PATHS_M.items()},
        'rmse': 'of x and of y over the 40 points of a path, path points exact',
        'iterated': "the paper's method, stopping at 1 px; iterated_exact: stopping at 0",
        'by_ratio, by_stop': "how far the paper's equal ratios are from the exact cell, and its "
        'stop at 1 px from the ratio solved for',
        'crb_ratio_max': 'RMSE over the Cramer-Rao bound, what lenses usually are included '
        '(van Trees), pooled over the points of all five paths, the worse axis of the worst '
        'spacing',
        'crb_ratio_of_a_path_max': 'not pooled: the worst axis of the worst single path',
        'refused': _refusals(k1),
        'planes': 'reference [17]: largest rectangle of grid points in the image, and in its '
        'middle half',
        'paper': "the paper's figures are of another pose, which it does not give",
    }
