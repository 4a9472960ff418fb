"""Several persons in one blob: where each stands, from predictions and the foreground."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
HEIGHT_STEP_M = 0.05


@dataclass(frozen=True)
class PartitionConfig:
    """Parameters of `partition`."""

    rows: int = parameter(
        24, 'height of a person in the reduced mask that is searched [px]', minimum=6, maximum=200
    )
    body_width_m: float = parameter(0.45, 'width of the body that is fitted [m]', minimum=0.05)
    background_weight: float = parameter(
        0.6, 'cost of background under a body, foreground explained being 1', minimum=0.0
    )
    certainty: float = parameter(12.0, 'log-likelihood of a wholly explained body', minimum=0.0)
    new_share: float = parameter(
        0.45, 'share of a body newly explained that makes another person', minimum=0.0, maximum=1.0
    )
    most_new: int = parameter(4, 'most new persons in one blob', minimum=0, maximum=16)
    odd_width: float = parameter(
        1.8, 'width from which a blob is more than one person, in usual widths', minimum=1.0
    )
    odd_height: float = parameter(
        1.25, 'height from which a blob is more than one person, in usual heights', minimum=1.0
    )
    least_visible: float = parameter(
        0.15, 'share of a body that must be seen to measure it', minimum=0.0, maximum=1.0
    )
    least_proven: float = parameter(
        0.25,
        'share of a body that must explain what older tracks do not, to be sure of it',
        minimum=0.0,
        maximum=1.0,
    )
    sweeps: int = parameter(2, 'rounds of placing each person given the others', minimum=1)


@dataclass(frozen=True, eq=False, slots=True)
class Bodies:
    """
    Persons placed in one blob.

    Attributes
    ----------
    foot : (n, 2) float64 array
        Foot points, px.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    visible : (n,) float64 array
        Share of the body that is foreground and not behind another body.
    proven : (n,) float64 array
        Share of the body that is foreground which no member before it in the order explains.

    """

    foot: Floats
    box: Floats
    visible: Floats
    proven: Floats


class _Canvas:
    """
    The blob's mask in cells, with every place where a body may stand.

    A place is the flat index of its foot's cell; ``explained`` and ``worth`` are shares of the
    body's area.
    """

    def __init__(
        self,
        mask: NDArray[np.uint8],
        box: Floats,
        scale: float,
        sizes: SizeTable,
        height_m: float,
        config: PartitionConfig,
    ) -> None:
        left, top, width, height = box
        middle = left + width / 2
        expected = float(sizes.per_metre(np.array([[middle, top + height]]))[0, 1]) * height_m
        step = max(expected / config.rows, scale)
        columns, rows = (max(1, int(np.ceil(size / step))) for size in (width, height))
        first, last = np.rint(np.array([[left, top], [left + width, top + height]]) / scale)
        part = mask[int(first[1]) : int(last[1]), int(first[0]) : int(last[0])]
        small = cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA)
        foreground = small.astype(np.float32) / 255
        self._foreground = foreground
        self._value = foreground - config.background_weight * (1 - foreground)
        self._background_weight = config.background_weight
        self._shape = (rows, columns)
        self._step = step
        self._feet = left + (np.arange(columns) + 0.5) * step, top + np.arange(1, rows + 1) * step
        pixel = np.column_stack([np.full(rows, middle), self._feet[1]])
        self._across, self._metre = (sizes.per_metre(pixel) / step).T
        self._across = self._across * config.body_width_m
        self._windows: dict[float, tuple[Ints, ...]] = {}

    def log_prior(self, predicted: Floats, spread: Floats) -> Floats:
        """Return the log-likelihood of every place given a predicted foot point, px."""
        precision = np.linalg.inv(spread)
        across, down = self._feet[0] - predicted[0], self._feet[1] - predicted[1]
        distance = (
            precision[0, 0] * across[None] ** 2
            + 2 * precision[0, 1] * across[None] * down[:, None]
            + precision[1, 1] * down[:, None] ** 2
        )
        result: Floats = -0.5 * distance.ravel()
        return result

    def uncovered(self, places: list[tuple[int, float]]) -> NDArray[np.bool_]:
        """Return the cells that no body at these places, of these heights, covers."""
        free = np.ones(self._shape, np.bool_)
        for place, height_m in places:
            free[self._slices(place, height_m)] = False
        return free

    def worth(self, free: NDArray[np.bool_], height_m: float) -> Floats:
        """Return what a body at every place is worth: foreground less weighted background."""
        low, high, area, outside = self._window(height_m)[:4]
        columns = self._shape[1] + 1
        total = cv2.integral(self._value * free).ravel()
        left, right = self._window(height_m)[4:]
        sums = (
            total[high * columns + right]
            - total[low * columns + right]
            - total[high * columns + left]
            + total[low * columns + left]
        )
        result: Floats = (sums - self._background_weight * outside) / area
        return result

    def explained(self, free: NDArray[np.bool_], place: int, height_m: float) -> float:
        """Return the share of a body that is free foreground."""
        part = self._slices(place, height_m)
        area = float(self._window(height_m)[2][place])
        return float((self._foreground[part] * free[part]).sum()) / area

    def body(self, place: int, height_m: float) -> tuple[Floats, Floats]:
        """Return foot (2,) and box (4,), px, of a body."""
        row, column = divmod(place, self._shape[1])
        foot = np.array([self._feet[0][column], self._feet[1][row]])
        width, height = np.array([self._across[row], self._metre[row] * height_m]) * self._step
        return foot, np.array([foot[0] - width / 2, foot[1] - height, width, height])

    def _slices(self, place: int, height_m: float) -> tuple[slice, slice]:
        low, high, _, _, left, right = (column[place] for column in self._window(height_m))
        return slice(int(low), int(high)), slice(int(left), int(right))

    def _window(self, height_m: float) -> tuple[Ints, ...]:
        """Return top, bottom, area, area beyond the blob, left, right of a body at all places."""
        if height_m not in self._windows:
            rows, columns = self._shape
            bottom = np.arange(1, rows + 1)
            top = np.minimum(np.rint(bottom - self._metre * height_m), bottom - 1)
            column = np.arange(columns) + 0.5
            left = np.rint(column[None] - self._across[:, None] / 2)
            right = np.maximum(np.rint(column[None] + self._across[:, None] / 2), left + 1)
            area = (bottom - top)[:, None] * (right - left)
            low, first = np.maximum(top, 0), np.maximum(left, 0)
            last = np.minimum(right, columns)
            inside = (bottom - low)[:, None] * (last - first)
            whole = [low[:, None], bottom[:, None], area, area - inside, first, last]
            self._windows[height_m] = tuple(
                np.broadcast_to(each, self._shape).ravel().astype(np.int64) for each in whole
            )
        return self._windows[height_m]


def partition(
    mask: NDArray[np.uint8],
    box: Floats,
    scale: float,
    sizes: SizeTable,
    predicted: Floats,
    spread: Floats,
    height_m: Floats,
    usual_height_m: float,
    config: PartitionConfig,
) -> Bodies:
    """
    Place persons in a blob: the known ones near their predictions, then new ones.

    Each is a body of expected size that should explain foreground, contain little background and
    stand near its prediction; places are improved in turn, given the others (event-tracking
    paper, section 4.2: prediction and the foreground of the group are incorporated).

    Parameters
    ----------
    mask : (h, w) uint8 array
        Cleaned foreground, reduced by `scale`.
    box : (4,) array
        The blob, px.
    scale : float
        Pixels of the picture to one of the mask.
    sizes : SizeTable
        Of the camera.
    predicted : (n, 2) array
        Predicted foot points of known members, px.
    spread : (n, 2, 2) array
        Covariance of the predictions, px².
    height_m : (n,) array
        Heights of the members, m.
    usual_height_m : float
        Height of a person who is not known, m.
    config : PartitionConfig
        Parameters.

    Returns
    -------
    Bodies
        The members in their order, then new persons.

    """
    canvas = _Canvas(mask, box, scale, sizes, usual_height_m, config)
    heights = [round(height / HEIGHT_STEP_M) * HEIGHT_STEP_M for height in height_m.tolist()]
    priors = [canvas.log_prior(*member) for member in zip(predicted, spread)]
    places: dict[int, tuple[int, float]] = {}
    nearest_first = np.argsort(-predicted[:, 1], kind='stable').tolist()
    for _ in range(config.sweeps if len(heights) > 1 else 1):
        for member in nearest_first:
            others = [places[other] for other in places if other != member]
            worth = canvas.worth(canvas.uncovered(others), heights[member])
            best = int(np.argmax(config.certainty * worth + priors[member]))
            places[member] = best, heights[member]
    while len(places) < len(heights) + config.most_new:
        worth = canvas.worth(canvas.uncovered(list(places.values())), usual_height_m)
        best = int(np.argmax(worth))
        if worth[best] < config.new_share:
            break
        places[len(places)] = best, usual_height_m
    return _bodies(canvas, [places[member] for member in range(len(places))])


def _bodies(canvas: _Canvas, places: list[tuple[int, float]]) -> Bodies:
    """Look up where the bodies are and how much of each is seen."""
    foot, box = np.zeros((len(places), 2)), np.zeros((len(places), 4))
    visible, proven = np.zeros((2, len(places)))
    for index, (place, height_m) in enumerate(places):
        foot[index], box[index] = canvas.body(place, height_m)
    for index, (place, height_m) in enumerate(places):
        nearer = [places[other] for other in np.flatnonzero(foot[:, 1] > foot[index, 1])]
        visible[index] = canvas.explained(canvas.uncovered(nearer), place, height_m)
        before = canvas.uncovered(places[:index])
        proven[index] = canvas.explained(before, place, height_m)
    return Bodies(foot, box, visible, proven)
