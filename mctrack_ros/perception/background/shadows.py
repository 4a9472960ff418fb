"""Shadows: learned from where they lie, taken out of the foreground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.background.shadow_pixels import (
    FIELD_PX,
    VOTER_PX,
    colourfulness,
    mark,
    nothing_but_shade,
    remove,
    remove_faint,
    votes,
)

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
DIRECTIONS = 24
DARKEST, BRIGHTEST = 0.35, 0.92
"""Share of the light that shade has: a wide range, from which the factor is learned."""
LEAST_SURPLUS = 0.33
"""Share of what may be shade that must lie where one sun puts it, beyond that where the opposite
does, to believe in shadows; by trial: PETS, nearly overcast, stays below."""
LEAST_PIXELS = 30.0  # that must have voted in the time constant, by trial
PERIOD_S = 0.8  # between looks for the sun, which does not move
MEMORY_S = 5.0  # time constant with which earlier looks are forgotten: of several steps
LEAST_SHADE = 0.1  # of what bodies cover; what is less is clothes
FAITH = 0.6  # share of the surplus that keeps the belief
MARGIN = 0.08  # of the factor, about what was learned
SAMPLE_PX = 16  # every so many pixels it is looked whether there are colours
LEAST_COLOUR = 2.0  # mean difference of blue and red from which there are, grey levels


@dataclass(frozen=True)
class ShadowConfig:
    """Parameters of `Shadows`."""

    suppress: bool = parameter(True, 'shadows are looked for and taken out of the foreground')
    longest_m: float = parameter(5.0, 'length of the longest shadows [m]', minimum=0.1)
    faint_share: float = parameter(
        0.0,
        'what is darker by no more than this share is shade, wherever it lies; 0: not so',
        minimum=0.0,
        maximum=0.9,
    )


class Shadows:
    """
    Finds out whether, and where to, shadows fall and takes them out of the foreground.

    A shadow is darker than the ground by one factor, whatever the texture; it lies on the ground,
    hangs on who throws it, and all fall in one direction. That direction and the factor are
    learned from pixels that may be shade. Without such agreement nothing is taken out, so grey or
    dark clothes alone are not mistaken. Where shadows fall along the upright, they cannot be told
    from bodies and are left.

    Parameters
    ----------
    config : ShadowConfig
        Parameters.
    mapping : GroundMapping
        Of the camera.
    scale : float
        Pixels of the camera's image to one of these.

    Attributes
    ----------
    sun : (2,) float64 array or None
        Unit vector on the ground towards the sun; None: no shadows.

    """

    def __init__(self, config: ShadowConfig, mapping: GroundMapping, scale: float) -> None:
        self._config = config
        self._field = _field(mapping, scale)
        angle = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        self._direction = np.column_stack([np.cos(angle), np.sin(angle)])
        self.restart()

    def restart(self) -> None:
        """Forget what was learned."""
        self.sun: Floats | None = None
        self._tint, self._factor = np.ones(3), 0.0
        self._votes, self._body = np.zeros((DIRECTIONS, 5)), 0.0
        self._kind = np.zeros((0, 0), np.uint8)
        self._last_ns: int | None = None
        self._next_ns = 0

    def take_out(
        self, image: Image, model: Image, mask: Image, noise: float, stamp_ns: int
    ) -> None:
        """
        Learn from an image and take shadows out of its foreground.

        Parameters
        ----------
        image, model : (h, w, 3) uint8 array
            Image and background.
        mask : (h, w) uint8 array
            Foreground, 255; changed in place.
        noise : float
            Standard deviation of a channel's noise, grey levels.
        stamp_ns : int
            Time of the image, ns.

        """
        if faint := self._config.faint_share:
            remove_faint(image, model, 1 - faint, mask)
        looks = stamp_ns >= self._next_ns
        if not self._config.suppress or not (looks or self.sun is not None):
            return
        if self._kind.shape != mask.shape:
            self._kind = np.zeros_like(mask)
        if looks:
            self._look(image, model, mask, noise, stamp_ns)
        if self.sun is not None:
            darkest = max(self._factor - MARGIN, DARKEST)
            mark(image, model, mask, self._tint, darkest, BRIGHTEST, noise, self._kind)
            remove(self._kind, self._field, self.sun, self._config.longest_m, mask)

    def alone(
        self, image: Image, model: Image, mask: Image, box: Floats, area: Floats, noise: float
    ) -> NDArray[np.bool_]:
        """
        Tell which blobs, (n,), are shadows by themselves: on walls, or of whom nobody sees.

        They are darker than the background by one factor all over, and of its colours. Nobody
        is so from head to foot where there are colours; in grey images many are.

        Parameters
        ----------
        image, model, mask, noise
            As in `take_out`; the mask is left as it is.
        box : (n, 4) array
            Left, top, width, height, px.
        area : (n,) array
            Foreground in each, px.

        """
        may_be_shade = self._config.suppress and len(box)
        if not may_be_shade or colourfulness(image, SAMPLE_PX) < LEAST_COLOUR:
            return np.zeros(len(box), np.bool_)
        return nothing_but_shade(image, model, mask, box, area, DARKEST, BRIGHTEST, noise)

    def _look(self, image: Image, model: Image, mask: Image, noise: float, stamp_ns: int) -> None:
        """Let pixels vote and count."""
        body = mark(image, model, mask, self._tint, DARKEST, BRIGHTEST, noise, self._kind)
        found = votes(
            image, model, self._kind, self._field, self._direction, self._config.longest_m
        )
        seconds = 0.0 if self._last_ns is None else (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns
        self._next_ns = stamp_ns + round(PERIOD_S * 1e9)
        kept = np.exp(-seconds / MEMORY_S)
        self._votes = kept * self._votes + found
        self._body = kept * self._body + body / VOTER_PX**2
        self._judge()

    def _judge(self) -> None:
        """Believe in the direction for which clearly more vote than for its opposite."""
        least = max(LEAST_PIXELS, LEAST_SHADE * self._body)
        share = self._votes[:, 0] / np.maximum(self._votes[:, 1], least)
        surplus = share - np.roll(share, DIRECTIONS // 2)
        best = int(surplus.argmax())
        believed = LEAST_SURPLUS * (1.0 if self.sun is None else FAITH)
        if surplus[best] < believed:
            self.sun = None
            self._tint, self._factor = np.ones(3), 0.0
            return
        near = np.arange(best - 1, best + 2) % DIRECTIONS
        sun = np.clip(surplus[near], 0.0, None) @ self._direction[near]
        self.sun = sun / np.linalg.norm(sun)
        factors = self._votes[best, 2:] / self._votes[best, 0]
        self._factor = float(factors.mean())
        self._tint = factors / self._factor


def _field(mapping: GroundMapping, scale: float) -> Floats:
    """Return the (r, c, 2, 2) px/m by which the image moves with the ground."""
    width, height = mapping.image_size
    step = FIELD_PX * scale
    column, row = np.meshgrid(
        np.arange(step / 2, width + step, step), np.arange(step / 2, height + step, step)
    )
    ground = mapping.ground_from_image(np.column_stack([column.ravel(), row.ravel()]))
    jacobian = mapping.image_jacobian(ground) / scale
    return np.ascontiguousarray(jacobian.reshape(*column.shape, 2, 2))
