"""Several persons in one blob: where each stands, from predictions and the foreground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.canvas import HEIGHT_STEP_M, TALLEST, Body, Canvas, Place
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    canvas = Canvas(
        image,
        mask,
        box,
        scale,
        sizes,
        usual_height_m,
        width_m,
        config.rows,
        config.background_weight,
    )
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


def _described(canvas: Canvas, bodies: list[Body]) -> Bodies:
    """Look up where the bodies are and how much of each is seen."""
    box, proven = np.zeros((len(bodies), 4)), np.zeros(len(bodies))
    older = canvas.empty()
    for index, body in enumerate(bodies):
        box[index] = canvas.box(*body)
        proven[index] = canvas.explained(older, body)
        canvas.add(older, body)
    apart = older.max(initial=0) < 2
    return Bodies(box, proven.copy() if apart else _visible(canvas, bodies), proven)


def _visible(canvas: Canvas, bodies: list[Body]) -> Floats:
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
