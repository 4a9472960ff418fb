"""Several persons in a blob: where each stands, from predictions and the foreground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.blob_split.template_fit import Search, place
from mctrack_ros.perception.blob_split.types import Bodies, Members
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.tracking.appearance import Palette

Floats = NDArray[np.float64]


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
    least_alike: float = parameter(
        0.5,
        'likeness (intersection over union) to its tracks below which a usual blob is new',
        minimum=0.0,
        maximum=1.0,
    )
    least_visible: float = parameter(
        0.15, 'share of a body that must be seen to measure it', minimum=0.0, maximum=1.0
    )
    least_coloured: float = parameter(
        0.3,
        'share of a body that must be seen to tell its colours, and not those remembered',
        minimum=0.0,
        maximum=1.0,
    )
    least_proven: float = parameter(
        0.35,
        'share of a body that must explain what older tracks do not, to be sure of it',
        minimum=0.0,
        maximum=1.0,
    )
    sweeps: int = parameter(2, 'rounds of placing each person given the others', minimum=1)


def partition(
    frame: Frame,
    blob: Floats,
    sizes: SizeTable,
    members: Members,
    usual_height_m: float,
    palette: Palette,
    config: PartitionConfig,
) -> Bodies:
    """
    Place persons in blobs: the known ones near their predictions, then new ones.

    Each is a body of expected size that should explain foreground of its colours, contain little
    background and stand near its prediction; places are improved in turn, given the others
    (event-tracking paper, section 4.2: prediction and the foreground of the group together).

    Parameters
    ----------
    frame : Frame
        With its foreground.
    blob : (b, 4) array
        Boxes of the blobs, px.
    sizes : SizeTable
        Of the camera.
    members : Members
        Who is known to be in them.
    usual_height_m : float
        Height of a person who is not known, m.
    palette : Palette
        What templates count.
    config : PartitionConfig
        Parameters.

    Returns
    -------
    Bodies
        The members and new persons.

    """
    search = Search(
        usual_height_m,
        config.body_width_m,
        config.body_share,
        config.rows,
        config.background_weight,
        config.certainty,
        config.new_share,
        config.most_new,
        config.sweeps,
    )
    return place(frame.image, frame.mask, blob, frame.scale, sizes.table, members, palette, search)
