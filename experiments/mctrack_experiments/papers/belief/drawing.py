"""The paper's Figures 4 to 7, of a scripted match."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.belief.methods import Methods, mapping_of
from mctrack_experiments.papers.belief.protocol import AFTER_S, GATE_M
from mctrack_experiments.papers.belief.scenes import Kind, Occlusion, OcclusionScene
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Belief
from mctrack_ros.perception.belief.view import boxes_of, foot_covariance
from mctrack_ros.simulation.pitch import field

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Colour = tuple[int, int, int]

ZOOM, HALF_PX = 6, 32
"""Cuts show so many pixels to each side of the target, each so many times as large."""
SHOWN = 40
"""Particles drawn in a cut."""
SIGMAS = 2.0
TOP_PX_PER_M = 12
MARGIN_PX, JOINED_PX = 45, 900
"""Figures 4 and 7 show so much about the targets; views are so wide."""
YELLOW, WHITE, RED = (0, 230, 255), (255, 255, 255), (40, 40, 230)
COLOURS: tuple[Colour, ...] = (
    (0, 230, 255), (255, 255, 0), (255, 0, 255), (255, 255, 255), (0, 140, 255)
)  # fmt: skip


class Run(NamedTuple):
    """Methods after a scene, and by step and view the particles of both trackers."""

    methods: Methods
    belief: list[dict[str, Belief]]
    alone: list[dict[str, Belief]]


def draw_figures(scene: OcclusionScene) -> dict[int, Image]:
    """Return the figures by their number in the paper."""
    methods, belief, alone = Methods(scene), [], []
    for _ in methods.steps():
        belief.append(dict(methods.belief.ground.views))
        alone.append({name: each.belief for name, each in methods.alone.filters.items()})
    run = Run(methods, belief, alone)
    occlusion = _telling(scene, methods)
    begin, end = scene.hidden(occlusion)
    steps = [
        begin - 5,
        (begin + end) // 2,
        end - 1 + round(AFTER_S * scene.world.scenario.rate_hz),
    ]
    names = list(methods.alone.filters)
    hidden = names[occlusion.cameras[0]]
    return {
        4: _spreads(scene),
        5: np.vstack([_cuts(scene, run.belief, name, occlusion.target, steps) for name in names]),
        6: _cuts(scene, run.alone, hidden, occlusion.target, steps),
        7: _trajectories(scene, methods),
    }


def _telling(scene: OcclusionScene, methods: Methods) -> Occlusion:
    """Return an occlusion in one view that belief propagation survives, and Condensation not."""
    after = round(AFTER_S * scene.world.scenario.rate_hz)
    names = list(methods.alone.filters)

    def contrast(occlusion: Occlusion) -> int:
        step, target = scene.hidden(occlusion)[1] - 1 + after, occlusion.target
        place = scene.truth[step, target]
        is_kept = [
            bool(np.hypot(*(methods.tracks[name][step, target] - place)) <= GATE_M)
            for name in ('belief', names[occlusion.cameras[0]])
        ]
        return int(is_kept[0]) - int(is_kept[1])

    return max((each for each in scene.occlusions if each.kind != Kind.BOTH_VIEWS), key=contrast)


def _spreads(scene: OcclusionScene) -> Image:
    """
    Draw what a view knows of places (Figure 4).

    Red: targets in a view; yellow: the covariance of the place on the ground that follows, seen
    from above on the right; white: the same carried into the other view.
    """
    cameras = list(scene.world.views(0))
    mappings = [mapping_of(camera) for camera in cameras]
    shown = [renderer.frame(0)[0].copy() for renderer in scene.renderers]
    top = _pitch()
    places = scene.truth[0]
    for index, mapping in enumerate(mappings):
        other = 1 - index
        foot = foot_covariance(mapping.height_px(places, 1.75))
        spread = mapping.ground_covariance(places, foot)
        jacobian = mappings[other].image_jacobian(places)
        carried = jacobian @ spread @ jacobian.transpose(0, 2, 1)
        feet = [each.image_from_ground(places) for each in mappings]
        for row in range(len(places)):
            cv2.circle(shown[index], _pixel(feet[index][row]), 2, RED, -1, cv2.LINE_AA)
            _ellipse(shown[other], feet[other][row], carried[row], WHITE)
            scaled = spread[row] * TOP_PX_PER_M**2
            _ellipse(top, _on_top(places[row]), scaled, (YELLOW, COLOURS[4])[index])
    return _beside([*shown, top], mappings, places)


def _cuts(
    scene: OcclusionScene,
    particles: list[dict[str, Belief]],
    name: str,
    target: int,
    steps: list[int],
) -> Image:
    """Draw the particles of a target in a view at some steps, and a ring where he truly is."""
    names = [camera.name for camera in scene.world.views(0)]
    tiles = []
    for step in steps:
        camera = scene.world.views(step)[names.index(name)]
        image = scene.renderers[names.index(name)].frame(step)[0]
        mapping = mapping_of(camera)
        foot = mapping.image_from_ground(scene.truth[step, target][None])[0]
        middle = foot - [0, mapping.height_px(scene.truth[step, target][None], 1.75)[0] / 2]
        rows = particles[step].get(name)
        box = np.zeros((0, 4))
        if rows is not None:
            own = (rows.track_id == target + 1) & (rows.view > 0)
            box = boxes_of(rows.image_state[own].astype(np.float64))[:: max(own.sum() // SHOWN, 1)]
        tiles.append(_cut(image, middle, box, foot))
    return np.hstack(tiles)


def _cut(image: Image, middle: Floats, box: Floats, foot: Floats) -> Image:
    corner = middle - HALF_PX
    shift = np.array([[1.0, 0, -corner[0]], [0, 1.0, -corner[1]]]) * ZOOM
    size = (2 * HALF_PX * ZOOM,) * 2
    cut = cv2.warpAffine(image, shift, size, flags=cv2.INTER_NEAREST)
    for left, top, width, height in (box - [*corner, 0, 0]) * ZOOM:
        cv2.rectangle(cut, _pixel((left, top)), _pixel((left + width, top + height)), YELLOW, 1)
    cv2.circle(cut, _pixel((foot - corner) * ZOOM), 8, RED, 2, cv2.LINE_AA)
    return np.asarray(cv2.copyMakeBorder(cut, 2, 2, 2, 2, cv2.BORDER_CONSTANT), np.uint8)


def _trajectories(scene: OcclusionScene, methods: Methods) -> Image:
    """Draw where belief propagation has all targets, in both views and on the ground."""
    places = methods.tracks['belief']
    mappings = [mapping_of(camera) for camera in scene.world.views(0)]
    shown = [renderer.frame(0)[0].copy() for renderer in scene.renderers]
    top = _pitch()
    for target, colour in enumerate(COLOURS):
        path = places[np.isfinite(places[:, target, 0]), target]
        for image, mapping in zip(shown, mappings):
            _line(image, mapping.image_from_ground(path), colour)
        _line(top, _on_top(path), colour)
    return _beside([*shown, top], mappings, scene.truth.reshape(-1, 2))


def _pitch() -> Image:
    size = (round(field.WIDTH_M * TOP_PX_PER_M), round(field.LENGTH_M * TOP_PX_PER_M))
    drawn = np.full((*size, 3), (60, 110, 60), np.uint8)
    for line in field.painted_lines():
        _line(drawn, _on_top(line), WHITE)
    return drawn


def _on_top(place: Floats) -> Floats:
    return np.asarray(
        np.stack([place[..., 0], field.WIDTH_M - place[..., 1]], axis=-1) * TOP_PX_PER_M
    )


def _beside(images: list[Image], mappings: list[ProjectiveMapping], places: Floats) -> Image:
    """Join what views and the ground, the last image, show about some places, (n, 2) m."""
    pixels = [*(mapping.image_from_ground(places) for mapping in mappings), _on_top(places)]
    cuts = []
    for image, pixel in zip(images, pixels):
        low = np.maximum(pixel.min(axis=0) - MARGIN_PX, 0).astype(int)
        high = (pixel.max(axis=0) + MARGIN_PX).astype(int)
        cuts.append(image[low[1] : high[1], low[0] : high[0]])
    views = np.vstack([_scaled(cut, JOINED_PX / cut.shape[1]) for cut in cuts[:-1]])
    return np.asarray(np.hstack([views, _scaled(cuts[-1], len(views) / len(cuts[-1]))]), np.uint8)


def _scaled(image: Image, scale: float) -> Image:
    size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_CUBIC), np.uint8)


def _ellipse(image: Image, centre: Floats, covariance: Floats, colour: Colour) -> None:
    values, axes = np.linalg.eigh(covariance)
    angle = float(np.degrees(np.arctan2(axes[1, 1], axes[0, 1])))
    long, short = SIGMAS * np.sqrt(np.maximum(values[::-1], 0.0))
    cv2.ellipse(
        image, (tuple(map(float, centre)), (2 * float(long), 2 * float(short)), angle), colour, 1,
        cv2.LINE_AA,
    )  # fmt: skip


def _line(image: Image, pixel: Floats, colour: Colour) -> None:
    cv2.polylines(image, [np.round(pixel).astype(np.int32)], False, colour, 1, cv2.LINE_AA)


def _pixel(place: Floats | tuple[float, float]) -> tuple[int, int]:
    column, row = np.round(place).astype(int).tolist()
    return column, row
