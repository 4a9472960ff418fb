"""What of a picture belongs to which local track: blobs, and bodies in shared blobs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_1D, FLOATS_2D, INTS_1D, compiled
from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.blobs import BlobConfig, Blobs, likeness_of_two
from mctrack_ros.perception.local_tracks import LocalTracks, Prediction
from mctrack_ros.perception.partition import Bodies, Members, PartitionConfig, partition
from mctrack_ros.perception.picture import Picture
from mctrack_ros.perception.sizes import SizeTable
from mctrack_ros.tracking.appearance import Palette

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
NEW = -1
_BOXES = types.f8[:, ::1]


@dataclass(frozen=True, eq=False, slots=True)
class Observations:
    """
    Persons seen in one picture, one row each.

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
        Where that stands, m.
    noise : (n, 2, 2) float64 array
        Covariance of the foot point, px².
    visible : (n,) float64 array
        Share of the body that is seen.
    proven : (n,) float64 array
        Share of the body that explains what no older track does.
    template : (n, 48) float64 array
        Colours of what is seen of it.
    fitted : (n,) bool array
        A body was placed in the blob; else the blob is the person.

    """

    track: Ints
    blob: Ints
    box: Floats
    foot: Floats
    position: Floats
    noise: Floats
    visible: Floats
    proven: Floats
    template: Floats
    fitted: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of persons."""
        return len(self.track)

    def select(self, index: NDArray[np.bool_] | NDArray[np.integer]) -> Observations:
        """Return the rows that a mask or an index array picks."""
        if index.dtype == np.bool_ and index.all():
            return self
        return Observations(*(getattr(self, name)[index] for name in self.__slots__))


class Observer:
    """
    Tells persons from blobs: a blob of usual size is one, in others bodies are placed.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    sizes : SizeTable
        Of the camera.
    blobs : BlobConfig
        A person's usual size.
    config : PartitionConfig
        Parameters.
    palette : Palette
        What templates count.

    """

    def __init__(
        self,
        mapping: GroundMapping,
        sizes: SizeTable,
        blobs: BlobConfig,
        config: PartitionConfig,
        palette: Palette,
    ) -> None:
        self._mapping, self._sizes = mapping, sizes
        self._blobs, self._config, self._palette = blobs, config, palette

    def observe(
        self,
        blob_of: Ints,
        tracks: LocalTracks,
        predicted: Prediction,
        blobs: Blobs,
        template: Floats,
        picture: Picture,
    ) -> Observations:
        """
        Return the persons in the blobs of a picture, by blob; none at the horizon or above it.

        Parameters
        ----------
        blob_of : (t,) int64 array
            Row of the blob that each track is in; -1: none.
        tracks : LocalTracks
            The camera's tracks.
        predicted : Prediction
            Where they are expected.
        blobs : Blobs
            Of the picture.
        template : (n, 48) array
            Colours of the blobs.
        picture : Picture
            With its foreground.

        """
        config = self._config
        alone, single, track_in, best = _told(
            blob_of,
            predicted.box,
            blobs.box,
            blobs.expected,
            blobs.truncated,
            config.odd_width,
            config.odd_height,
            config.single_width,
            config.least_alike,
        )
        shared = np.flatnonzero(~alone)
        row, blob, bodies = self._placed(shared, blob_of, tracks, predicted, blobs, picture)
        proven = np.where(single[blob] & (row != best[blob]), 0.0, bodies.proven)
        columns = _joined(
            alone,
            track_in,
            blobs.box,
            template,
            blob,
            row,
            bodies.box,
            bodies.visible,
            proven,
            bodies.template,
        )
        return self._on_ground(columns, tracks, blobs)

    def _placed(
        self,
        shared: Ints,
        blob_of: Ints,
        tracks: LocalTracks,
        predicted: Prediction,
        blobs: Blobs,
        picture: Picture,
    ) -> tuple[Ints, Ints, Bodies]:
        """Place the tracks that are in some blobs, and new persons: row, blob and body of each."""
        rows, number = _members(shared, blob_of)
        members = Members(
            number,
            predicted.bottom[rows],
            predicted.spread[rows],
            tracks.extent[rows],
            tracks.template[rows],
        )
        box, usual_height_m = blobs.box[shared], self._blobs.person_height_m
        bodies = partition(
            picture, box, self._sizes, members, usual_height_m, self._palette, self._config
        )
        track = np.full(len(bodies.box), NEW)
        track[bodies.is_known] = rows
        return track, shared[bodies.blob], bodies

    def _on_ground(
        self, columns: tuple[NDArray[Any], ...], tracks: LocalTracks, blobs: Blobs
    ) -> Observations:
        """Look up where the feet of persons stand; `columns` are those of `_joined`."""
        track, blob, box, visible, proven, template, fitted = columns
        foot = self._sizes.foot_of(box)
        position = self._mapping.ground_from_image(foot)
        noise = tracks.foot_noise(box)
        _add_doubt(
            noise,
            fitted,
            visible,
            self._config.least_visible,
            blob,
            blobs.truncated,
            blobs.expected,
            blobs.box,
        )
        seen = Observations(
            track, blob, box, foot, position, noise, visible, proven, template, fitted
        )
        tall = self._sizes.per_metre(foot)[:, 1] * self._blobs.person_height_m
        near_enough = tall >= self._blobs.farthest_height_px  # so below the horizon, too
        return seen.select(np.isfinite(position).all(axis=1) & near_enough)


@compiled(
    types.Tuple([types.b1[::1]] * 2 + [types.i8[::1]] * 2)(
        INTS_1D, FLOATS_2D, FLOATS_2D, FLOATS_2D, BOOLS_1D, *[types.f8] * 4
    )
)
def _told(
    blob_of: Ints, predicted: Floats, box: Floats, expected: Floats, truncated: Booleans,
    odd_width: float, odd_height: float, single_width: float, least_alike: float,
) -> tuple[Booleans, Booleans, Ints, Ints]:  # fmt: skip
    """
    Tell which blobs are one person each.

    Returns
    -------
    alone : (n,) bool array
        Which look like one whole person and hold at most one track, or look like one person, but
        like none of their tracks.
    single : (n,) bool array
        Which others are no larger than one person: who else is in it must be hidden.
    track : (n,) int64 array
        Row of the track that each is which is alone, -1: none.
    best : (n,) int64 array
        Row of the track in each that is most like it, -1: none.

    """
    count = len(box)
    alone, single = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    track, best = np.full(count, NEW), np.full(count, NEW)
    for blob in range(count):
        members, most, least = 0, 0.0, 0.0
        for row in range(len(blob_of)):
            if blob_of[row] == blob:
                members, least = members + 1, predicted[row, 3]
                alike = likeness_of_two(predicted[row], box[blob])
                if alike > most or members == 1:
                    most, best[blob] = alike, row
        width, height = box[blob, 2], box[blob, 3]
        usual_width, usual_height = expected[blob]
        small = width <= odd_width * usual_width and height <= odd_height * usual_height
        not_halved = height * odd_height > min(least, usual_height)
        whole = members < 2 and (truncated[blob] or (small and not_halved))
        fits_one = width / usual_width < single_width and height / usual_height < odd_height
        single[blob] = not whole and fits_one
        strange = single[blob] and most < least_alike
        alone[blob] = whole or strange
        track[blob] = NEW if strange else best[blob]
    return alone, single, track, best


@compiled(types.UniTuple(types.i8[::1], 2)(INTS_1D, INTS_1D))
def _members(shared: Ints, blob_of: Ints) -> tuple[Ints, Ints]:
    """Return the rows of the tracks in some blobs, and which of these each is in; by blob."""
    rows, number = np.empty(len(blob_of), np.int64), np.empty(len(blob_of), np.int64)
    count = 0
    for index in range(len(shared)):
        for row in range(len(blob_of)):
            if blob_of[row] == shared[index]:
                rows[count], number[count] = row, index
                count += 1
    return rows[:count], number[:count]


@compiled(
    types.Tuple(
        [*[types.i8[::1]] * 2, _BOXES, *[types.f8[::1]] * 2, _BOXES, types.b1[::1]]
    )(
        BOOLS_1D, INTS_1D, FLOATS_2D, FLOATS_2D,
        INTS_1D, INTS_1D, FLOATS_2D, FLOATS_1D, FLOATS_1D, FLOATS_2D,
    )
)  # fmt: skip
def _joined(
    alone: Booleans, track_in: Ints, blob_box: Floats, template: Floats,
    body_blob: Ints, body_track: Ints, body_box: Floats, body_visible: Floats,
    body_proven: Floats, body_template: Floats,
) -> tuple[Ints, Ints, Floats, Floats, Floats, Floats, Booleans]:  # fmt: skip
    """Return columns of `Observations`: blobs that are one person, bodies in others, by blob."""
    count = np.count_nonzero(alone) + len(body_blob)
    track, blob = np.empty(count, np.int64), np.empty(count, np.int64)
    box, colours = np.empty((count, 4)), np.empty((count, template.shape[1]))
    visible, proven = np.ones(count), np.ones(count)
    fitted = np.zeros(count, np.bool_)
    row = body = 0
    for index in range(len(alone)):
        if alone[index]:
            track[row], blob[row] = track_in[index], index
            box[row], colours[row] = blob_box[index], template[index]
            row += 1
        while body < len(body_blob) and body_blob[body] == index:
            track[row], blob[row], fitted[row] = body_track[body], index, True
            box[row], colours[row] = body_box[body], body_template[body]
            visible[row], proven[row] = body_visible[body], body_proven[body]
            row, body = row + 1, body + 1
    return track, blob, box, visible, proven, colours, fitted


@compiled(
    types.void(
        types.Array(types.f8, 3, 'C'), BOOLS_1D, FLOATS_1D, types.f8,
        INTS_1D, BOOLS_1D, FLOATS_2D, FLOATS_2D,
    )
)  # fmt: skip
def _add_doubt(
    noise: Floats, fitted: Booleans, visible: Floats, least_visible: float,
    blob: Ints, truncated: Booleans, expected: Floats, box: Floats,
) -> None:  # fmt: skip
    """Add to the noise of feet what is hidden of bodies, and cut off by the picture's edge."""
    for row in range(len(noise)):
        if fitted[row]:
            hidden = 1 / min(max(visible[row], least_visible), 1.0)
            noise[row] *= hidden**2
        if truncated[blob[row]]:
            for axis in range(2):
                missing = max(expected[blob[row], axis] - box[blob[row], 2 + axis], 0.0)
                noise[row, axis, axis] += missing**2
