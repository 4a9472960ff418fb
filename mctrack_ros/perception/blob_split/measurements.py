"""Persons seen in one image: the blobs that are one, and bodies placed in others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, compiled
from mctrack_ros.perception.blob_split.single_blobs import NEW, SingleBlobs
from mctrack_ros.perception.blob_split.types import Bodies
from mctrack_ros.perception.geometry.foot_noise import foot_variance
from mctrack_ros.perception.geometry.person_size import foot_below, metre_at

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
LEAST_VISIBLE = 0.15
"""Share of a body that must be seen to measure it; by trial on simulated matches, as the next."""
LEAST_OWN_SHARE = 0.35
"""Least share of a body that is foreground which no older track explains."""


class Observations(NamedTuple):
    """
    Persons seen in one image, one row each.

    Attributes
    ----------
    track : (n,) int64 array
        Row of the local track, -1: none yet.
    blob : (n,) int64 array
        Blob that it is in.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    foot : (n, 2) float64 array
        Foot point, px.
    position : (n, 2) float64 array
        Its ground position, m; of a vehicle, the middle of its footprint.
    noise : (n, 2, 2) float64 array
        Covariance of the foot point, px².
    visible : (n,) float64 array
        Share of the body that is seen.
    own_share : (n,) float64 array
        Share of the body that is foreground which no older track explains.
    template : (n, 48) float64 array
        Colours of what is seen of it.
    fitted : (n,) bool array
        A body was placed in the blob; else the blob is the person.
    depth : (n, 2) float64 array
        Footprint of a vehicle, from its near to its far end, m; 0: a person.

    """

    track: Ints
    blob: Ints
    box: Floats
    foot: Floats
    position: Floats
    noise: Floats
    visible: Floats
    own_share: Floats
    template: Floats
    fitted: Booleans
    depth: Floats

    def select(self, mask: Booleans) -> Observations:
        """Return the rows that a mask picks."""
        if mask.all():
            return self
        return Observations(*(column[mask] for column in self))  # type: ignore[arg-type]


_TABLE = types.f8[:, ::1]
OBSERVATIONS = types.NamedTuple(
    [
        types.i8[::1], types.i8[::1], _TABLE, _TABLE, _TABLE, types.f8[:, :, ::1],
        types.f8[::1], types.f8[::1], _TABLE, types.b1[::1], _TABLE,
    ],
    Observations,
)  # fmt: skip


class Footing(NamedTuple):
    """
    How well foot points are seen.

    Attributes
    ----------
    noise_px : float
        Standard deviation of a foot point, part that is the same for all, px.
    noise_share : float
        Part that grows with the box, as a share of its height.
    height_m : float
        Usual height of a person, m.
    least_height_px : float
        Where he would look smaller than this, he is too far away, px.

    """

    noise_px: float
    noise_share: float
    height_m: float
    least_height_px: float


FOOTING = types.NamedUniTuple(types.f8, 4, Footing)


def gathered(
    singles: SingleBlobs,
    bodies: Bodies,
    shared: Ints,
    rows: Ints,
    blob_box: Floats,
    template: Floats,
) -> Observations:
    """
    Put blobs that are one person and bodies in the others together, by blob.

    Parameters
    ----------
    singles : SingleBlobs
        Of all blobs.
    bodies : Bodies
        Fitted in the blobs that are not one person.
    shared : (b,) int64 array
        Rows of these.
    rows : (k,) int64 array
        Track of each known body, in order.
    blob_box, template : (n, 4) and (n, 48) arrays
        Boxes of all blobs, px, and their colours.

    Returns
    -------
    Observations
        Without foot points, positions and noise: see `footed`.

    """
    alone, body_blob = np.flatnonzero(singles.alone), shared[bodies.blob]
    track = np.full(len(body_blob), NEW)
    track[bodies.is_known] = rows
    hidden = singles.single[body_blob] & (track != singles.best[body_blob])
    own_share = np.where(hidden, 0.0, bodies.own_share)
    whole, count = np.ones(len(alone)), len(alone) + len(body_blob)
    blob = np.concatenate([alone, body_blob])
    order = blob.argsort(kind='stable')
    nowhere = np.empty((count, 2))
    return Observations(
        np.concatenate([singles.track[alone], track])[order],
        blob[order],
        np.concatenate([blob_box[alone], bodies.box])[order],
        nowhere,
        nowhere,
        np.zeros((count, 2, 2)),
        np.concatenate([whole, bodies.visible])[order],
        np.concatenate([whole, own_share])[order],
        np.concatenate([template[alone], bodies.template])[order],
        order >= len(alone),
        np.zeros((count, 2)),
    )


@compiled(
    types.Tuple([_TABLE, types.f8[:, :, ::1], types.b1[::1]])(
        OBSERVATIONS, FLOATS_3D, BOOLS_1D, FLOATS_2D, FLOATS_2D, FLOATS_2D, FOOTING
    )
)
def footed(
    seen: Observations, sizes: Floats, truncated: Booleans, expected: Floats, blob_box: Floats,
    noise_ratio: Floats, footing: Footing,
) -> tuple[Floats, Floats, Booleans]:  # fmt: skip
    """
    Find the feet of persons.

    Occluded and truncated bodies have a larger covariance.

    Parameters
    ----------
    seen : Observations
        The persons.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`.
    truncated, expected, blob_box : (n,) bool, (n, 2) and (n, 4) arrays
        Of the blobs: which touch the edge, the size of a person there and their boxes, px.
    noise_ratio : (t, 2) array
        Variance of each track's foot points over the default.
    footing : Footing
        How well feet are seen.

    Returns
    -------
    foot : (n, 2) array
        Foot points, px.
    noise : (n, 2, 2) array
        Their covariance, px².
    near : (n,) bool array
        Which are below the horizon, and not too far away.

    """
    foot, noise = np.empty((len(seen.box), 2)), np.zeros((len(seen.box), 2, 2))
    near = np.empty(len(seen.box), np.bool_)
    for row in range(len(seen.box)):
        box, blob = seen.box[row], seen.blob[row]
        x, y = foot_below(sizes, box[0], box[1], box[2], box[3])
        foot[row, 0], foot[row, 1] = x, y
        near[row] = metre_at(sizes, x, y)[1] * footing.height_m >= footing.least_height_px
        variance = foot_variance(box[3], footing.noise_px, footing.noise_share)
        hidden = 1 / min(max(seen.visible[row], LEAST_VISIBLE), 1.0)
        variance *= hidden**2
        for axis in range(2):
            observed = 1.0 if seen.track[row] == NEW else noise_ratio[seen.track[row], axis]
            noise[row, axis, axis] = variance * observed
            if truncated[blob]:
                missing = expected[blob, axis] - blob_box[blob, 2 + axis]
                noise[row, axis, axis] += max(missing, 0.0) ** 2
    return foot, noise, near
