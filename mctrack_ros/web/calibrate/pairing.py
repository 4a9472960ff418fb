"""Pairs of scene points and their places in an image: made, mended, fitted, saved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import (
    CalibrationError,
    CameraFit,
    GridError,
    TransformationGrid,
    check_plausible,
    fit_camera,
    grid_flaws,
    grid_from_points,
    write_grid,
)
from mctrack_ros.web.history import History, Undoable

Floats = NDArray[np.float64]
Pixel = tuple[float, float]
Pairs = dict[str, Pixel]
CLICK_NOISE_PX = 0.5
"""Standard deviation of a click along one axis, px: that with which the grid is fitted later."""
SUSPICIOUS = 4.0
"""Residual from which a point is suspicious, in deviations of a click or median residuals."""


class PairingError(ValueError):
    """A step that makes no sense for these pairs; says why."""


class Pairing(Undoable[Pairs]):
    """
    The TG-creator's state (event-tracking paper, section 4.4): which point is seen where.

    A pair is made by choosing a point and then its place, or the reverse. At every change the
    camera is fitted again.

    Parameters
    ----------
    camera : str
        Name of the camera, the workstation of the grid file.
    scene : mapping of str to (float, float)
        x and y of each point, m, by its name.
    image_size : (int, int)
        Width and height of the image, px.

    Attributes
    ----------
    names : tuple of str
        Of the scene's points.
    ground : (n, 2) array
        Where they are, m.
    fit : CameraFit or None
        The camera fitted to the pairs, its points in the order of `pairs`.
    reason : str
        Why there is no camera; empty if there is one.
    chosen : str
        The point that was chosen last, or empty.
    waiting : (float, float) or None
        A place in the image that waits for its point, px.

    """

    def __init__(
        self, camera: str, scene: Mapping[str, tuple[float, float]], image_size: tuple[int, int]
    ) -> None:
        if not scene:
            raise PairingError('the scene has no points')
        self.camera, self.image_size = camera, image_size
        self.names = tuple(scene)
        self.ground = np.array(list(scene.values()), np.float64)
        self._row = {name: row for row, name in enumerate(self.names)}
        self._history: History[Pairs] = History({})
        self._fov: Floats | None = None
        self.chosen = ''
        self.waiting: Pixel | None = None
        self.fit: CameraFit | None = None
        self.reason = ''
        self._refit()

    @property
    def pairs(self) -> Pairs:
        """Pixel by name of the point, in the order of clicking."""
        return dict(self._history.present)

    @property
    def is_placing(self) -> bool:
        """Whether the next click into the image is the place of the chosen point."""
        return self.chosen != '' and self.chosen not in self._history.present

    def choose(self, name: str) -> None:
        """Choose a point of the scene; a place that waits becomes its own."""
        if name not in self._row:
            raise PairingError(f'the scene has no point {name!r}')
        if self.waiting is None:
            self.chosen = name
        else:
            self._put(name, self.waiting)

    def place(self, x: float, y: float) -> None:
        """Give the chosen point its place in the image, px; without one the place waits."""
        pixel = self._inside(x, y)
        if self.is_placing:
            self._put(self.chosen, pixel)
        else:
            self.chosen, self.waiting = '', pixel

    def move(self, name: str, x: float, y: float) -> None:
        """Put a paired point elsewhere in the image, px."""
        self._check_paired(name)
        self._put(name, self._inside(x, y))
        self.chosen = name

    def delete(self, name: str) -> None:
        """Take a pair apart."""
        self._check_paired(name)
        self._step({other: pixel for other, pixel in self.pairs.items() if other != name})

    def forget(self) -> None:
        """Choose nothing; no place waits."""
        self.chosen, self.waiting = '', None

    def resume(self, grid: TransformationGrid) -> None:
        """
        Take the pairs of a grid written before, as one step.

        Raises
        ------
        PairingError
            If the grid is another camera's or holds points that the scene has not.

        """
        if grid.workstation != self.camera:
            raise PairingError(f'the grid is that of {grid.workstation!r}, not of {self.camera!r}')
        pairs = self.pairs
        names, ground, image = grid.named_points()
        for name, place, pixel in zip(names, ground, image.tolist()):
            row = self._row.get(name)
            if row is None or not np.allclose(self.ground[row], place, atol=1e-6):
                raise PairingError(
                    f'the grid of {self.camera!r} has a point {name!r} at '
                    f'({place[0]:.12g}, {place[1]:.12g}) m, the scene has not'
                )
            pairs[name] = self._inside(*pixel)
        self._fov = grid.fov
        self._step(pairs)

    def residual_px(self) -> dict[str, float]:
        """Return how far each pair lies from where the fitted camera sees it; empty without."""
        if self.fit is None:
            return {}
        return dict(zip(self.pairs, np.hypot(*self.fit.residual.T).tolist()))

    def suspicious(self) -> tuple[str, ...]:
        """Return the points that lie too far from where the camera sees them, worst first."""
        residual = self.residual_px()
        usual = max(CLICK_NOISE_PX, median(residual.values() or [0.0]))
        far = [name for name, px in residual.items() if px > SUSPICIOUS * usual]
        return tuple(sorted(far, key=lambda name: -residual[name]))

    def grid(self) -> tuple[TransformationGrid, tuple[str, ...]]:
        """
        Return the grid of the pairs, and the points of no complete cell, which it leaves out.

        Raises
        ------
        GridError
            If there is no complete cell, or one that cannot be so.

        """
        pairs = self.pairs
        ground, image = self._paired(pairs)
        bare, ignored = grid_from_points(self.camera, tuple(pairs), ground, image)
        grid = replace(bare, fov=self._fov, image_size=self.image_size)
        for _, flaw in grid_flaws(grid):
            raise GridError(flaw)
        return grid, ignored

    def save(self, path: str | Path) -> tuple[str, ...]:
        """
        Write the grid file (event-tracking paper, Algorithm 2); return the points left out.

        Raises
        ------
        GridError
            As `grid`; nothing is written then.

        """
        grid, ignored = self.grid()
        write_grid(grid, path)
        return ignored

    def _inside(self, x: float, y: float) -> Pixel:
        width, height = self.image_size
        if not (0 <= x <= width and 0 <= y <= height):
            raise PairingError(f'({x:.1f}, {y:.1f}) is outside the image')
        return (round(float(x), 3), round(float(y), 3))

    def _check_paired(self, name: str) -> None:
        if name not in self._history.present:
            raise PairingError(f'{name!r} has no place in the image')

    def _put(self, name: str, pixel: Pixel) -> None:
        self._step({**self.pairs, name: pixel})

    def _step(self, pairs: Pairs) -> None:
        self._history.step(pairs)
        self._changed()

    def _changed(self) -> None:
        self.forget()
        self._refit()

    def _paired(self, pairs: Pairs) -> tuple[Floats, Floats]:
        rows = [self._row[name] for name in pairs]
        return self.ground[rows], np.array(list(pairs.values()), np.float64).reshape(-1, 2)

    def _refit(self) -> None:
        ground, image = self._paired(self._history.present)
        try:
            fit = fit_camera(ground, image, self.image_size, CLICK_NOISE_PX)
            check_plausible(fit.mapping, ground)
            self.fit, self.reason = fit, ''
        except CalibrationError as error:
            self.fit, self.reason = None, str(error)
