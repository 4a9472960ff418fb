"""Persons in blobs that several may share: those known to be in them, and those found there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Members(NamedTuple):
    """
    Known persons in some blobs, one row each: blob by blob, in each the oldest first.

    Attributes
    ----------
    blob : (n,) int64 array
        Row of the blob that each is in, ascending.
    bottom : (n, 2) float64 array
        Bottom centres of the predicted boxes, px.
    spread : (n, 2, 2) float64 array
        Covariance of a measured one about the predicted, px².
    extent : (n, 2) float64 array
        Width and height, m.
    template : (n, 48) float64 array
        Colours, zero where not known.

    """

    blob: Ints
    bottom: Floats
    spread: Floats
    extent: Floats
    template: Floats


class Bodies(NamedTuple):
    """
    Persons placed in some blobs: blob by blob the known in their order, then new ones.

    Attributes
    ----------
    blob : (n,) int64 array
        Row of the blob that each is in.
    is_known : (n,) bool array
        Whether it is one of the members.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    visible : (n,) float64 array
        Share of the body that is foreground and not behind another body.
    own_share : (n,) float64 array
        Share of the body that is foreground which no member before it in the order explains.
    template : (n, 48) float64 array
        Colours of what is seen of it past those nearer to the camera; zero where nothing is.

    """

    blob: Ints
    is_known: NDArray[np.bool_]
    box: Floats
    visible: Floats
    own_share: Floats
    template: Floats


_TABLE = types.f8[:, ::1]
MEMBERS = types.NamedTuple([types.i8[::1], _TABLE, types.f8[:, :, ::1], _TABLE, _TABLE], Members)
BODIES = types.NamedTuple(
    [types.i8[::1], types.b1[::1], _TABLE, types.f8[::1], types.f8[::1], _TABLE], Bodies
)
