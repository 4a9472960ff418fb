"""Whether clicked points make a calibration to be trusted, and which of them does not fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.camera.fit import CLICK_NOISE_PX, CameraFit, FitError, fit_camera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid
from mctrack_ros.ground.plausible import check_plausible

Floats = NDArray[np.float64]
SUSPICIOUS = 4.0
"""Standard deviations from where the other points put it at which a point is suspicious."""
MOST_SUSPECTS = 0.25
"""No more than this share of the points is suspected: the others have to decide."""
LARGEST_MISS_PX = 2.0
LARGEST_MISS_SHARE = 1 / 400
"""Left-out error up to which a calibration is accepted: px, or share of the longer side."""
SHARES = (1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 4 / 3, 3 / 2, 2, 3, 4)
BETTER = 0.5
"""A size is suggested if its residual is at most this share: .5 is twice as close."""


@dataclass(frozen=True, eq=False, slots=True)
class CalibrationCheck:
    """
    What a camera's points say about its calibration.

    Attributes
    ----------
    names : tuple of str
        Of the points.
    residual_px : (n,) array
        Distance of each click from where the camera fitted to all sees the point; NaN without one.
    left_out_px : (n,) array
        The same for the camera fitted without the point (and without suspicious ones).
    score : (n,) array
        The latter in standard deviations: of a click and of that camera together; NaN where no
        single points are to blame.
    suspicious : tuple of str
        Points that do not fit the others, worst first.
    deviation_m : float
        Standard deviation of ground positions at the points, median, from the calibration alone.
    refusal : str
        Why the calibration is refused; empty: it is accepted.

    """

    names: tuple[str, ...]
    residual_px: Floats
    left_out_px: Floats
    score: Floats
    suspicious: tuple[str, ...]
    deviation_m: float
    refusal: str

    @property
    def rms_px(self) -> float:
        """Reprojection error: root mean square of the residuals, px."""
        return _rms(self.residual_px)

    @property
    def left_out_rms_px(self) -> float:
        """Leave-one-out error: root mean square over the points, px."""
        return _rms(self.left_out_px)

    def warnings(self) -> tuple[str, ...]:
        """Return a sentence for each suspicious point."""
        off = dict(zip(self.names, self.left_out_px.tolist()))
        return tuple(
            f'point {name} is {off[name]:.3g} px off: check it' for name in self.suspicious
        )


def check_grid(
    grid: TransformationGrid, image_size: tuple[int, int], click_noise_px: float = CLICK_NOISE_PX
) -> CalibrationCheck:
    """
    Check the calibration that a grid's points give.

    Each point is held against the camera fitted without it: its distance, in standard deviations
    of click and camera, is a studentised residual, that a wrong point cannot hide by pulling the
    camera along. The worst one beyond 4 is named and left out, and the rest is checked again;
    where more than a quarter of the points are too far off, none is to blame alone. The
    calibration is accepted if a camera can be fitted and can be true, no point is suspicious, the
    leave-one-out error is at most 2 px, or 1/400 of the image's longer side if that is more, and
    its lens is not unusual.

    Parameters
    ----------
    grid : TransformationGrid
        The points.
    image_size : (int, int)
        Width and height of the images, px.
    click_noise_px : float
        Standard deviation of a click along one axis, px.

    """
    names, ground, image = grid.named_points()
    most = _most_px(image_size)
    try:
        fit = _fitted(grid, image_size, click_noise_px)
    except CalibrationError as error:
        nothing = np.full(len(names), np.nan)
        reason = f'{error}{size_hint(grid, image_size, np.inf, most)}'
        return CalibrationCheck(names, nothing, nothing, nothing, (), np.nan, reason)
    residual = np.linalg.norm(fit.residual, axis=1)
    missed, score = np.linalg.norm(fit.left_out, axis=1), np.full(len(names), np.nan)
    suspects: list[int] = []
    if (residual > most).mean() <= MOST_SUSPECTS:
        missed, score, suspects = _suspected(ground, image, image_size, click_noise_px)
    spread = np.trace(fit.mapping.calibration_covariance(ground), axis1=1, axis2=2)
    refusal = _refusal([names[index] for index in suspects], _rms(missed), most, fit.oddity)
    refusal = _with_hint(refusal, fit, grid, click_noise_px)
    return CalibrationCheck(
        names,
        residual,
        missed,
        score,
        tuple(names[index] for index in suspects),
        float(np.sqrt(np.median(spread))),
        refusal,
    )


def _suspected(
    ground: Floats, image: Floats, image_size: tuple[int, int], click_noise_px: float
) -> tuple[Floats, Floats, list[int]]:
    """Return left-out misses, (n,) px and (n,) deviations, and the points that do not fit."""
    kept = np.ones(len(ground), np.bool_)
    suspects: list[int] = []
    while True:
        missed, score = _Points(ground, image, image_size, click_noise_px, kept).left_out()
        worst = int(np.argmax(np.where(kept & (score >= 0), score, -1.0)))
        if not score[worst] > SUSPICIOUS or len(suspects) + 1 > MOST_SUSPECTS * len(ground):
            return missed, score, suspects
        suspects.append(worst)
        kept[worst] = False


def first_look(
    grid: TransformationGrid, image_size: tuple[int, int], click_noise_px: float = CLICK_NOISE_PX
) -> str:
    """
    Return why a calibration is to be doubted, by the residuals of its fit; empty: it is not.

    Quick: a fit without each point is known from the fit with all to first order, where
    `check_grid` fits anew.

    Parameters
    ----------
    grid : TransformationGrid
        The points.
    image_size : (int, int)
        Width and height of the images, px.
    click_noise_px : float
        Standard deviation of a click along one axis, px.

    """
    names, most = grid.named_points()[0], _most_px(image_size)
    try:
        fit = _fitted(grid, image_size, click_noise_px)
    except CalibrationError as error:
        return f'{error}{size_hint(grid, image_size, np.inf, most)}'
    missed = np.linalg.norm(fit.residual, axis=1)
    far = np.flatnonzero(missed > SUSPICIOUS * fit.noise_px).tolist()
    off = _rms(np.linalg.norm(fit.left_out, axis=1))
    refusal = _refusal([names[index] for index in far], off, most, fit.oddity)
    return _with_hint(refusal, fit, grid, click_noise_px)


def _fitted(
    grid: TransformationGrid, image_size: tuple[int, int], click_noise_px: float
) -> CameraFit:
    """Return the camera of all points; `CalibrationError` if there is none that can be true."""
    grid.check_size(image_size)
    _, ground, image = grid.named_points()
    fit = fit_camera(ground, image, image_size, click_noise_px)
    check_plausible(fit.mapping, ground)
    return fit


def _most_px(image_size: tuple[int, int]) -> float:
    """Return up to which left-out error a calibration is accepted, px."""
    return max(LARGEST_MISS_PX, LARGEST_MISS_SHARE * max(image_size))


@dataclass(frozen=True, eq=False, slots=True)
class _Points:
    """Clicked points, and which of them are believed."""

    ground: Floats
    image: Floats
    size: tuple[int, int]
    noise_px: float
    kept: NDArray[np.bool_]

    def left_out(self) -> tuple[Floats, Floats]:
        """
        Return how far each point is from where the others put it: (n,) px, (n,) deviations.

        The camera without one point is near the camera with all: the fit begins there, and anew
        only where the point then looks suspicious, for such a one may have led the others astray.
        """
        found = np.full((len(self.ground), 2), np.nan)
        whole = self._fit(self.kept)
        for index in range(len(self.ground)):
            if not self.kept[index]:
                found[index] = self._miss(whole, index)
                continue
            others = self.kept.copy()
            others[index] = False
            found[index] = self._miss(self._fit(others, whole), index)
            if not found[index, 1] <= SUSPICIOUS:
                found[index] = self._miss(self._fit(others), index)
        return found[:, 0], found[:, 1]

    def _fit(self, used: NDArray[np.bool_], near: CameraFit | None = None) -> CameraFit | None:
        """Return the camera of some of the points, sought near another; None: they give none."""
        start = None if near is None else near.mapping.camera
        try:
            return fit_camera(self.ground[used], self.image[used], self.size, self.noise_px, start)
        except FitError:
            return None

    def _miss(self, fit: CameraFit | None, index: int) -> tuple[float, float]:
        """Return how far a point is from where a camera sees it: px, deviations."""
        if fit is None:
            return np.nan, np.nan
        ground = self.ground[index][None]
        seen = fit.mapping.image_from_ground(ground)[0]
        if not np.isfinite(seen).all():
            return np.nan, np.inf
        away = self.image[index] - seen
        camera = fit.mapping.image_covariance(ground, fit.mapping.calibration_covariance(ground))
        expected = camera[0] + fit.noise_px**2 * np.eye(2)
        return float(np.linalg.norm(away)), float(np.sqrt(away @ np.linalg.solve(expected, away)))


def _refusal(suspects: list[str], left_out_px: float, most_px: float, oddity: str) -> str:
    if suspects:
        return f'{len(suspects)} of its points do not fit the others: {", ".join(suspects)}'
    if np.isnan(left_out_px):
        return 'no point can be left out to check it by the others: add points'
    if not left_out_px <= most_px:
        return (
            f'points are {left_out_px:.2g} px from where the others put them, expected at most '
            f'{most_px:.2g} px'
        )
    if oddity:
        return f'the camera is unusual, {oddity}: is the image cropped or of another size?'
    return ''


def _with_hint(
    refusal: str, fit: CameraFit, grid: TransformationGrid, click_noise_px: float
) -> str:
    """Return why a camera is refused, with the image size that its points fit much better."""
    if not refusal and fit.noise_px <= click_noise_px:
        return ''
    size = fit.mapping.image_size
    hint = size_hint(grid, size, closeness_px(fit), _most_px(size))
    return (refusal or (hint and f'points are {fit.rms_px:.2g} px off')) + hint


def _rms(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt((known**2).mean())) if len(known) else float('nan')


def size_hint(
    grid: TransformationGrid, image_size: tuple[int, int], rms_px: float, most_px: float
) -> str:
    """
    Return what to ask of a grid that does not fit its images: whether they were scaled.

    A camera's axis goes nearly through the middle of its image, so points of a smaller or larger
    one do not fit, or make the camera unusual.

    Parameters
    ----------
    grid : TransformationGrid
        The points.
    image_size : (int, int)
        Width and height of the images that they do not fit, px.
    rms_px : float
        How far they miss, px; infinite: they give no camera, or an unusual one.
    most_px : float
        How far they may miss in another size, px.

    Returns
    -------
    str
        Begins with a semicolon; empty: no other size fits, or the grid states its own.

    """
    if grid.image_size is not None:
        return ''
    sizes = [(round(image_size[0] * share), round(image_size[1] * share)) for share in SHARES]
    missed = {size: _missed_px(grid, size) for size in sizes}
    best = min(missed, key=lambda size: missed[size])
    if not missed[best] <= min(BETTER * rms_px, most_px):
        return ''
    return (
        f'; they fit images of {best[0]} x {best[1]} px: is the image size '
        f'{image_size[0]} x {image_size[1]} px wrong for this grid?'
    )


def _missed_px(grid: TransformationGrid, size: tuple[int, int]) -> float:
    """Return how far the points miss for images of a size; infinite: they give no camera."""
    try:
        grid.check_size(size)
        return closeness_px(fit_camera(*grid.points(), size))
    except CalibrationError:
        return float('inf')


def closeness_px(fit: CameraFit) -> float:
    """Return how far a camera misses its points, px; infinite: its lens is unusual."""
    return float('inf') if fit.oddity else fit.rms_px
