"""Several persons in a blob: where each stands, from predictions and the foreground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.blob_split.template_fit import place
from mctrack_ros.perception.blob_split.types import Bodies, Members
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.geometry.person_size import SizeTable

Floats = NDArray[np.float64]


def partition(
    frame: Frame,
    blob: Floats,
    sizes: SizeTable,
    members: Members,
    usual_height_m: float,
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

    Returns
    -------
    Bodies
        The members and new persons.

    """
    return place(
        frame.image,
        frame.mask,
        blob,
        frame.scale,
        sizes.table,
        members,
        usual_height_m,
        frame.balance,
    )
