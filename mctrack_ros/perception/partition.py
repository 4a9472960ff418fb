"""Several persons in one blob: where each stands, from predictions and the foreground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.sizes import SizeTable
from mctrack_ros.tracking.appearance import colour_likelihood

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
HEIGHT_STEP_M = 0.05
TALLEST = 1.15
RARE = 0.01  # likelihood of a colour that was not seen before
Place = tuple[int, int]
Body = tuple[Place, float]  # foot's cell and height, m


@dataclass(frozen=True)
class PartitionConfig:
    """Parameters of `partition`."""

    rows: int = parameter(
        24, 'height of a person in the reduced mask that is searched [px]', minimum=6, maximum=200
    )
    body_width_m: float = parameter(0.5, 'width of the body that is fitted [m]', minimum=0.05)
    body_share: float = parameter(
        0.7, 'width of the body, as a share of the known width of a person in motion', minimum=0.0
    )
    background_weight: float = parameter(
        0.9, 'cost of background under a body, foreground explained being 1', minimum=0.0
    )
    certainty: float = parameter(12.0, 'log-likelihood of a wholly explained body', minimum=0.0)
    new_share: float = parameter(
        0.6, 'share of a body newly explained that makes another person', minimum=0.0, maximum=1.0
    )
    most_new: int = parameter(4, 'most new persons in one blob', minimum=0, maximum=16)
    odd_width: float = parameter(
        1.8, 'width from which a blob is more than one person, in usual widths', minimum=1.0
    )
    single_width: float = parameter(
        1.4, 'width below which a blob shows no more than one person, likewise', minimum=1.0
    )
    odd_height: float = parameter(
        1.25, 'height from which a blob is more than one person, in usual heights', minimum=1.0
    )
    least_visible: float = parameter(
        0.15, 'share of a body that must be seen to measure it', minimum=0.0, maximum=1.0
    )
    least_proven: float = parameter(
        0.35,
        'share of a body that must explain what older tracks do not, to be sure of it',
        minimum=0.0,
        maximum=1.0,
    )
    sweeps: int = parameter(2, 'rounds of placing each person given the others', minimum=1)


@dataclass(frozen=True, eq=False, slots=True)
class Members:
    """
    Known persons in one blob, one row each, the oldest first.

    Attributes
    ----------
    bottom : (n, 2) float64 array
        Bottom centres of the predicted boxes, px.
    spread : (n, 2, 2) float64 array
        Covariance of a measured one about the predicted, px².
    extent : (n, 2) float64 array
        Width and height, m.
    template : (n, 48) float64 array
        Colours, zero where not known.

    """

    bottom: Floats
    spread: Floats
    extent: Floats
    template: Floats


@dataclass(frozen=True, eq=False, slots=True)
class Bodies:
    """
    Persons placed in one blob.

    Attributes
    ----------
    box : (n, 4) float64 array
        Left, top, width, height, px.
    visible : (n,) float64 array
        Share of the body that is foreground and not behind another body.
    proven : (n,) float64 array
        Share of the body that is foreground which no member before it in the order explains.

    """

    box: Floats
    visible: Floats
    proven: Floats


class _Canvas:
    """
    The blob's mask in cells, with every place where a body may stand.

    A place is a cell (row, column) at the middle of the body's lower edge. Around the blob lies a
    margin of background into which bodies may reach.
    """

    def __init__(
        self,
        image: NDArray[np.uint8],
        mask: NDArray[np.uint8],
        box: Floats,
        scale: float,
        sizes: SizeTable,
        height_m: float,
        width_m: float,
        config: PartitionConfig,
    ) -> None:
        left, top, width, height = box.tolist()
        middle = left + width / 2
        expected = float(sizes.per_metre(np.array([[middle, top + height]]))[0, 1]) * height_m
        step = max(expected / config.rows, scale)
        columns, rows = max(1, math.ceil(width / step)), max(1, math.ceil(height / step))
        first = round(left / scale), round(top / scale)
        last = round((left + width) / scale), round((top + height) / scale)
        part = np.s_[first[1] : last[1], first[0] : last[0]]
        self._picture = image[part]
        foreground = cv2.resize(mask[part], (columns, rows), interpolation=cv2.INTER_AREA)
        self.shape = (rows, columns)
        self._step = step
        self._feet = left + (np.arange(columns) + 0.5) * step, top + np.arange(1, rows + 1) * step
        pixel = np.column_stack([np.full(rows, middle), self._feet[1]])
        across, self._metre = (sizes.per_metre(pixel) / step).T
        self._width = max(1, round(float(across[rows // 2]) * width_m))
        self._above = math.ceil(float(self._metre.max()) * (TALLEST * height_m + HEIGHT_STEP_M))
        self._side = side = self._width // 2
        self._foreground = np.zeros((self._above + rows, columns + self._width), np.float32)
        self._foreground[self._above :, side : side + columns] = foreground * np.float32(1 / 255)
        self._background_weight = np.float32(config.background_weight)
        self.value = self._valued(1.0)
        self._tops: dict[float, tuple[Ints, Floats]] = {}

    def values(self, template: Floats) -> list[NDArray[np.float32]]:
        """
        Return what each cell is worth to each of (n, 48) templates.

        Foreground of a colour that is more likely another member's is worth nothing, neither for
        nor against.
        """
        known = np.flatnonzero(template.any(axis=1))
        values = [self.value] * len(template)
        if len(known) < 2:
            return values
        rows, columns = self.shape
        picture = cv2.resize(self._picture, (columns, rows), interpolation=cv2.INTER_AREA)
        likelihood = colour_likelihood(np.asarray(picture, np.uint8), template[known]) + RARE
        share = np.minimum(len(known) * likelihood / likelihood.sum(axis=0), 1.0)
        padded = np.ones_like(self._foreground)
        for member, own in zip(known, share):
            padded[self._above :, self._side : self._side + columns] = own
            values[member] = self._valued(padded)
        return values

    def log_prior(self, predicted: Floats, precision: Floats) -> Floats:
        """Return the log-likelihood of every place given a predicted bottom centre, px."""
        across = self._feet[0][None] - predicted[0]
        down = self._feet[1][:, None] - predicted[1]
        (uu, uv), (_, vv) = precision.tolist()
        result: Floats = -0.5 * (uu * across**2 + (2 * uv * down) * across + vv * down**2)
        return result

    def _valued(self, share: NDArray[np.float32] | float) -> NDArray[np.float32]:
        weight = self._background_weight
        return np.asarray(self._foreground * (share + weight) - weight, np.float32)

    def empty(self) -> NDArray[np.float32]:
        """Return the count of bodies on each cell before there are any."""
        return np.zeros(self._foreground.shape, np.float32)

    def add(self, count: NDArray[np.float32], body: Body, number: int = 1) -> None:
        """Count a body, or with -1 take it away again, on the cells that it covers."""
        count[self._covered(*body)] += number

    def worth(
        self, value: NDArray[np.float32], count: NDArray[np.float32], height_m: float
    ) -> Floats:
        """Return what a body at every place, past those counted, is worth, as a share of it."""
        columns = self.shape[1]
        top, height = self._top(height_m)
        total = cv2.integral(value * (count == 0))
        strip = total[self._above + 1 :] - total[top]
        sums = strip[:, self._width : self._width + columns] - strip[:, :columns]
        result: Floats = sums / (height * self._width)[:, None]
        return result

    def explained(self, count: NDArray[np.float32], body: Body) -> float:
        """Return the share of a body that is foreground on which none is counted."""
        part = self._covered(*body)
        free = self._foreground[part][count[part] == 0]
        return float(free.sum()) / count[part].size

    def box(self, place: Place, height_m: float) -> list[float]:
        """Return left, top, width, height, px, of a body."""
        column, row = float(self._feet[0][place[1]]), float(self._feet[1][place[0]])
        width = self._width * self._step
        height = float(self._metre[place[0]]) * height_m * self._step
        return [column - width / 2, row - height, width, height]

    def _covered(self, place: Place, height_m: float) -> tuple[slice, slice]:
        row, column = place
        top = int(self._top(height_m)[0][row])
        return slice(top, self._above + row + 1), slice(column, column + self._width)

    def _top(self, height_m: float) -> tuple[Ints, Floats]:
        """Return upper edge, counted from the margin's, and height of a body in every row."""
        if height_m not in self._tops:
            bottom = self._above + np.arange(1, self.shape[0] + 1)
            height = np.clip(np.rint(self._metre * height_m), 1, bottom)
            self._tops[height_m] = (bottom - height).astype(np.int64), height
        return self._tops[height_m]


def partition(
    image: NDArray[np.uint8],
    mask: NDArray[np.uint8],
    box: Floats,
    scale: float,
    sizes: SizeTable,
    members: Members,
    usual_height_m: float,
    config: PartitionConfig,
) -> Bodies:
    """
    Place persons in a blob: the known ones near their predictions, then new ones.

    Each is a body of expected size that should explain foreground of its colours, contain little
    background and stand near its prediction; places are improved in turn, given the others
    (event-tracking paper, section 4.2: prediction and the foreground of the group together).

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        The picture, reduced by `scale`.
    mask : (h, w) uint8 array
        Cleaned foreground, reduced by `scale`.
    box : (4,) array
        The blob, px.
    scale : float
        Pixels of the picture to one of the mask.
    sizes : SizeTable
        Of the camera.
    members : Members
        Who is known to be in it.
    usual_height_m : float
        Height of a person who is not known, m.
    config : PartitionConfig
        Parameters.

    Returns
    -------
    Bodies
        The members in their order, then new persons.

    """
    width_m = max([config.body_width_m, *(config.body_share * members.extent[:, 0])])
    canvas = _Canvas(image, mask, box, scale, sizes, usual_height_m, width_m, config)
    heights = _heights(members.extent[:, 1], usual_height_m)
    precision = np.linalg.inv(members.spread)
    priors = [canvas.log_prior(*member) for member in zip(members.bottom, precision)]
    values = canvas.values(members.template)
    bodies: list[Body | None] = [None] * len(heights)
    count = canvas.empty()
    nearest_first = np.argsort(-members.bottom[:, 1], kind='stable').tolist()
    for _ in range(config.sweeps):
        for member in nearest_first:
            former = bodies[member]
            if former is not None:
                canvas.add(count, former, -1)
            worth = canvas.worth(values[member], count, heights[member])
            place = _best(config.certainty * worth + priors[member])
            bodies[member] = body = (place, heights[member])
            canvas.add(count, body)
        if count.max(initial=0) < 2:
            break
    placed = [body for body in bodies if body is not None]
    for _ in range(config.most_new):
        worth = canvas.worth(canvas.value, count, usual_height_m)
        place = _best(worth)
        if worth[place] < config.new_share:
            break
        placed.append((place, usual_height_m))
        canvas.add(count, placed[-1])
    return _described(canvas, placed)


def _heights(known_m: Floats, usual_m: float) -> list[float]:
    """Return heights, m, near the usual and rounded, so that few differ."""
    height = np.clip(known_m, (2 - TALLEST) * usual_m, TALLEST * usual_m)
    return [round(each / HEIGHT_STEP_M) * HEIGHT_STEP_M for each in height.tolist()]


def _described(canvas: _Canvas, bodies: list[Body]) -> Bodies:
    """Look up where the bodies are and how much of each is seen."""
    box, proven = np.zeros((len(bodies), 4)), np.zeros(len(bodies))
    older = canvas.empty()
    for index, body in enumerate(bodies):
        box[index] = canvas.box(*body)
        proven[index] = canvas.explained(older, body)
        canvas.add(older, body)
    apart = older.max(initial=0) < 2
    return Bodies(box, proven.copy() if apart else _visible(canvas, bodies), proven)


def _visible(canvas: _Canvas, bodies: list[Body]) -> Floats:
    """Return what is seen of each body past those whose feet are nearer to the camera."""
    visible = np.zeros(len(bodies))
    nearer = canvas.empty()
    for index in sorted(range(len(bodies)), key=lambda each: -bodies[each][0][0]):
        visible[index] = canvas.explained(nearer, bodies[index])
        canvas.add(nearer, bodies[index])
    return visible


def _best(score: Floats) -> Place:
    row, column = divmod(int(np.argmax(score)), score.shape[1])
    return row, column
