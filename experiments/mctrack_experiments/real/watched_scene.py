"""Quickly drawn images of a camera in the wind: light that drifts, crowds that pass."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation import Scenario, pitch5_cameras
from mctrack_ros.simulation.pitch.stadium import empty_image

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

SIZE = (768, 576)
MARGIN_PX = 64
RATE_HZ = 25.0
NOISE = 2.0  # grey levels
WIND_PX = 0.5
WIND_HZ = 0.6
WIND_DAMPING = 0.1
LIGHT_SHARE = 0.15
LIGHT_S = 240.0
CLOUD_SHARE = 0.25
CLOUD_S = 90.0
PEOPLE = 60
CROWD_S = 300.0
KINDS = ('pitch', 'square')


class WatchedScene:
    """
    One camera over hours; any instant can be drawn at once, each in a few milliseconds.

    Parameters
    ----------
    kind : str
        One of `KINDS`: the synthetic pitch, or a square with buildings and paving.
    seed : int
        Of everything.
    duration_s : float
        How long the wind blows, s.

    """

    def __init__(self, kind: str, seed: int, duration_s: float) -> None:
        self._rng = np.random.default_rng([seed, KINDS.index(kind)])
        width, height = (side + 2 * MARGIN_PX for side in SIZE)
        if kind == 'pitch':
            camera = pitch5_cameras(Scenario())[seed % 5]
            self._still = empty_image(replace(camera, size=(width, height)), self._rng)
        else:
            self._still = _square(width, height, self._rng)
        self.wind = _wind(round(duration_s * RATE_HZ) + 1, self._rng)
        noise = self._rng.normal(0, NOISE, (height, width, 3))
        self._brighter = np.clip(np.rint(noise), 0, 255).astype(np.uint8)
        self._darker = np.clip(np.rint(-noise), 0, 255).astype(np.uint8)
        count = (2 * PEOPLE,)
        self._start = self._rng.uniform(0, 1, count)
        self._speed = self._rng.normal(0, 0.06, count)  # image widths a second
        self._depth = np.sort(self._rng.uniform(0.15, 1.0, count))
        self._clothes = self._rng.integers(0, 255, (2 * PEOPLE, 2, 3))
        self._phase = self._rng.uniform(0, 2 * np.pi, 3)

    def image(self, time_s: float, moved: Floats | None = None) -> Image:
        """
        Draw the image of an instant.

        Parameters
        ----------
        time_s : float
            Since the start, s.
        moved : (2, 3) array, optional
            Where the points of the unmoved image lie, px from its middle; else where they were.

        """
        matrix = np.eye(2, 3) if moved is None else np.array(moved, float)
        matrix[:, 2] += self.wind[round(time_s * RATE_HZ)]
        middle = np.array(SIZE) / 2
        matrix[:, 2] += middle - matrix[:, :2] @ (middle + MARGIN_PX)
        scene = self._still.copy()
        self._draw_crowd(scene[MARGIN_PX:-MARGIN_PX, MARGIN_PX:-MARGIN_PX], time_s)
        image = np.asarray(
            cv2.warpAffine(scene, matrix, SIZE, borderMode=cv2.BORDER_REFLECT), np.uint8
        )
        image = self._lit(image, time_s)
        left, top = self._rng.integers(0, 2 * MARGIN_PX, 2)
        window = (slice(top, top + SIZE[1]), slice(left, left + SIZE[0]))
        return np.asarray(
            cv2.subtract(cv2.add(image, self._brighter[window]), self._darker[window]), np.uint8
        )

    def _draw_crowd(self, image: Image, time_s: float) -> None:
        """Draw who is there: none to all, over minutes; every fifth stands."""
        share = 0.5 - 0.5 * np.cos(2 * np.pi * time_s / CROWD_S + self._phase[0])
        width, height = SIZE
        for person in range(len(self._start)):
            if (person * 7919) % len(self._start) >= share * len(self._start):
                continue
            speed = 0.0 if person % 5 == 0 else self._speed[person]
            column = ((self._start[person] + speed * time_s) % 1.2 - 0.1) * width
            size = 0.32 * height * self._depth[person]
            row = height * (0.15 + 0.8 * self._depth[person])
            for part, (low, high) in enumerate(((0.5, 0.62), (0.0, 0.5))):
                foot = (round(column), round(row - size * (low + high) / 2))
                axes = (max(round(0.17 * size), 1), max(round(0.5 * size * (high - low) + 2), 1))
                colour = self._clothes[person, part].tolist()
                cv2.ellipse(image, foot, axes, 0, 0, 360, colour, -1)

    def _lit(self, image: Image, time_s: float) -> Image:
        """Change the light: all over slowly, and the shade of a cloud that passes."""
        whole = 1 + LIGHT_SHARE * np.sin(2 * np.pi * time_s / LIGHT_S + self._phase[1])
        across = np.linspace(0, 2 * np.pi, SIZE[0])
        cloud = np.sin(across - 2 * np.pi * time_s / CLOUD_S + self._phase[2])
        gain = (256 * whole * (1 - CLOUD_SHARE * (0.5 + 0.5 * cloud))).astype(np.uint16)
        lit = image * gain[None, :, None].astype(np.uint16) >> 8
        return np.asarray(np.minimum(lit, 255), np.uint8)


def _wind(count: int, rng: np.random.Generator) -> Floats:
    """Return the sway of a pole, (count, 2) px: a damped oscillation that gusts keep going."""
    step, omega = 1 / RATE_HZ, 2 * np.pi * WIND_HZ
    decay = np.exp(-WIND_DAMPING * omega * step)
    first = 2 * decay * np.cos(omega * step * np.sqrt(1 - WIND_DAMPING**2))
    second = -(decay**2)
    gust = rng.normal(size=(count, 2))
    sway = np.zeros((count, 2))
    for index in range(2, count):
        sway[index] = first * sway[index - 1] + second * sway[index - 2] + gust[index]
    return np.asarray(sway * (WIND_PX / np.sqrt((sway**2).mean())))


def _square(width: int, height: int, rng: np.random.Generator) -> Image:
    """Draw paving below facades with windows."""
    image = np.full((height, width, 3), 120.0)
    skyline = round(0.35 * height)
    for left in range(0, width, 140):
        colour = rng.uniform(60, 200, 3)
        image[:skyline, left : left + 140] = colour
        for top in range(20, skyline - 40, 55):
            for x in range(left + 15, left + 120, 40):
                image[top : top + 32, x : x + 22] = colour * rng.uniform(0.3, 0.7)
    for row in range(skyline, height, 24):
        for column in range(0, width, 36):
            shade = rng.uniform(0.85, 1.1)
            image[row : row + 22, column : column + 34] *= shade
    image += rng.normal(0, 3, image.shape)
    smooth = cv2.GaussianBlur(image, (0, 0), 0.8)
    return np.clip(smooth, 0, 255).astype(np.uint8)
