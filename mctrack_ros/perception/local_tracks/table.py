"""A camera's own tracks: extended Kalman filters on the ground, measured in pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, compiled
from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.perception.geometry.foot_noise import follow_noise, foot_noise
from mctrack_ros.perception.geometry.person_size import SizeTable, box_at
from mctrack_ros.perception.local_tracks.parallel_arrays import ParallelArrays
from mctrack_ros.perception.local_tracks.update import correct
from mctrack_ros.tracking import kalman

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
ROUND = np.eye(2)  # the same in all directions


@dataclass(frozen=True)
class FilterConfig:
    """Parameters of the local extended Kalman filters."""

    acceleration: float = parameter(
        2.5, 'standard deviation of the white acceleration [m/s² per root Hz]', minimum=0.0
    )
    initial_speed: float = parameter(
        2.5, "standard deviation of a new track's velocity [m/s]", minimum=0.0
    )
    foot_noise_px: float = parameter(
        0.7, 'standard deviation of the foot point, constant part [px]',
        minimum=0.01,
    )  # fmt: skip
    foot_noise_share: float = parameter(
        0.025, 'part that grows with the box, as a share of its height', minimum=0.0
    )
    noise_time_s: float = parameter(
        2.0,
        'time constant of the adaptive foot noise of each track, never below these; 0: not '
        'adaptive [s]',
        minimum=0.0,
    )


@dataclass(frozen=True, eq=False, slots=True)
class Prediction:
    """
    Where tracks are expected in the image, one row each.

    Attributes
    ----------
    foot : (n, 2) float64 array
        Foot points, px.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    spread : (n, 2, 2) float64 array
        Covariance of a measured foot point about the predicted, px².
    slope : (n, 2, 2) float64 array
        Derivative of the foot point by the place on the ground, px/m.
    seconds : float
        Since the last image, s.

    """

    foot: Floats
    box: Floats
    spread: Floats
    slope: Floats
    seconds: float

    def select(self, mask: Mask) -> Prediction:
        """Return the rows that a mask picks."""
        kept = self.foot[mask], self.box[mask], self.spread[mask], self.slope[mask]
        return Prediction(*kept, self.seconds)


class LocalTracks(ParallelArrays):
    """
    All local tracks of one camera as parallel arrays; rows are ordered by id.

    Attributes
    ----------
    mean : (n, 4) float64 array
        x, y (m), vx, vy (m/s) on the ground.
    covariance : (n, 4, 4) float64 array
        Of the mean.
    extent : (n, 2) float64 array
        Width and height, m, as if upright.
    template : (n, 48) float64 array
        Appearance.
    track_id : (n,) int64 array
        Global id that feedback taught; 0: none.
    first_ns, seen_ns : (n,) int64 array
        First and last time with a detection of its own, or in a group.
    clear_ns : (n,) int64 array
        Last time that enough of it was seen to be sure that it is there.
    confirmed : (n,) bool array
        Old enough to be confirmed.
    origin : (n, 2) float64 array
        Where it began, m.
    walked : (n,) bool array
        Whether it has moved away from there.
    class_id : (n,) uint8 array
        A `ClassCode`; unknown until it was seen as a whole.
    near_px : (n, 2) float64 array
        From where it stands in the image to its foot point: 0, but a vehicle stands in the
        middle of the ground that it covers, and its foot point is at the near end.
    noise_ratio : (n, 2) float64 array
        Variance of its foot points over the default, along x and y of
        the image.

    """

    mean: Floats = np.zeros(4)
    covariance: Floats = np.zeros((4, 4))
    extent: Floats = np.zeros(2)
    template: Floats = np.zeros(TEMPLATE_SIZE)
    track_id: Ints = np.zeros((), np.int64)
    first_ns: Ints = np.zeros((), np.int64)
    seen_ns: Ints = np.zeros((), np.int64)
    clear_ns: Ints = np.zeros((), np.int64)
    confirmed: Mask = np.zeros((), np.bool_)
    origin: Floats = np.zeros(2)
    walked: Mask = np.zeros((), np.bool_)
    class_id: NDArray[np.uint8] = np.zeros((), np.uint8)
    near_px: Floats = np.zeros(2)
    noise_ratio: Floats = np.ones(2)

    def __init__(self, config: FilterConfig, mapping: GroundMapping, sizes: SizeTable) -> None:
        self._config, self._mapping, self._sizes = config, mapping, sizes
        super().__init__()

    def clear(self) -> None:
        """Forget all tracks; ids go on."""
        super().clear()
        self._seconds = 0.0

    def predict(self, seconds: float) -> None:
        """Move all tracks on with constant velocity and white acceleration."""
        density = self._config.acceleration**2
        self._seconds = seconds
        self.mean, self.covariance = kalman.predict(self.mean, self.covariance, seconds, density)

    def prediction(self) -> Prediction:
        """Return where the tracks are expected in the image (the paper's KBB)."""
        place = np.ascontiguousarray(self.mean[:, :2])
        foot = np.ascontiguousarray(self._mapping.image_from_ground(place) + self.near_px)
        slope = np.ascontiguousarray(self._mapping.image_jacobian(place))
        box, spread = _expected(
            self._sizes.table,
            foot,
            self.extent,
            self.covariance,
            slope,
            self._config.foot_noise_px,
            self._config.foot_noise_share,
            self.noise_ratio,
        )
        return Prediction(foot, box, spread, slope, self._seconds)

    def update(self, predicted: Prediction, rows: Ints, foot: Floats, noise: Floats) -> None:
        """
        Correct some tracks with measured foot points; not those predicted behind the camera.

        Parameters
        ----------
        predicted : Prediction
            Of all tracks as they are.
        rows : (k,) int array
            Tracks; -1: none.
        foot : (k, 2) array
            Measured foot points, px.
        noise : (k, 2, 2) array
            Their covariance, px².

        """
        correct(self.mean, self.covariance, rows, predicted.foot, predicted.slope, foot, noise)
        way = np.hypot(*(self.mean[:, :2] - self.origin).T)
        spread = np.sqrt(self.covariance[:, [0, 1], [0, 1]].sum(axis=1))
        self.walked |= way > 3.0 * spread

    def follow_noise(
        self, predicted: Prediction, rows: Ints, foot: Floats, noise: Floats, seconds: float
    ) -> None:
        """
        Learn how well foot points are measured, before they correct the tracks.

        Parameters
        ----------
        predicted, rows, foot, noise
            As `update` takes them; rows -1 where it cannot be learned.
        seconds : float
            Since the last image, s.

        """
        if self._config.noise_time_s > 0.0 and len(self):
            pace = float(1 - np.exp(-seconds / self._config.noise_time_s))
            place = np.ascontiguousarray(self.covariance[:, :2, :2])
            spread = kalman.projections(place, predicted.slope)
            follow_noise(self.noise_ratio, rows, foot, predicted.foot, noise, spread, pace)

    def start(
        self, position: Floats, box: Floats, noise: Floats, template: Floats, stamp_ns: int
    ) -> Ints:
        """Start tracks at (k, 2) places, m, and return their rows."""
        count, old = len(position), len(self)
        covariance = np.zeros((count, 4, 4))
        covariance[:, :2, :2] = self._mapping.ground_covariance(position, noise)
        covariance[:, [2, 3], [2, 3]] = self._config.initial_speed**2
        self.append(
            count,
            mean=np.column_stack([position, np.zeros((count, 2))]),
            covariance=covariance,
            extent=box[:, 2:] / self._sizes.per_metre(self._sizes.foot_of(box)),
            template=template,
            origin=position,
            **dict.fromkeys(('first_ns', 'seen_ns', 'clear_ns'), np.full(count, stamp_ns)),
        )
        return np.arange(old, old + count)

    def stand(self, rows: Ints, position: Floats, foot: Floats) -> None:
        """
        Let vehicles stand in the middle of their ground; their near ends stay where expected.

        Parameters
        ----------
        rows : (k,) int array
            Tracks.
        position : (k, 2) array
            Where they are seen to stand, m.
        foot : (k, 2) array
            Foot points of their near ends, px.

        """
        near_px = foot - self._mapping.image_from_ground(position)
        end = self._mapping.image_from_ground(self.mean[rows, :2]) + self.near_px[rows]
        place = self._mapping.ground_from_image(end - near_px)
        known = np.isfinite(place).all(axis=1) & np.isfinite(near_px).all(axis=1)
        self.near_px[rows[known]] = near_px[known]
        self.mean[rows[known], :2] = place[known]

    def foot_noise(self, box: Floats) -> Floats:
        """Return the (n, 2, 2) covariance, px², of the foot points of (n, 4) boxes."""
        config = self._config
        return foot_noise(box, config.foot_noise_px, config.foot_noise_share)


@compiled(
    types.Tuple([types.f8[:, ::1], types.f8[:, :, ::1]])(
        FLOATS_3D, FLOATS_2D, FLOATS_2D, FLOATS_3D, FLOATS_3D, types.f8, types.f8, FLOATS_2D
    )
)
def _expected(
    sizes: Floats, foot: Floats, extent: Floats, covariance: Floats, slope: Floats,
    same_px: float, share: float, noise_ratio: Floats,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return the boxes of tracks at their foot points, and how these are measured about them."""
    box = np.empty((len(foot), 4))
    for row in range(len(foot)):
        box_at(sizes, foot[row], extent[row], box[row])
    spread = kalman.projections(covariance, slope)
    noise = foot_noise(box, same_px, share)
    for row in range(len(foot)):
        for axis in range(2):
            spread[row, axis, axis] += noise[row, axis, axis] * noise_ratio[row, axis]
    return box, spread
