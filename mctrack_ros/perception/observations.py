"""What of a picture belongs to which local track: blobs, and bodies in shared blobs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.blobs import BlobConfig, Blobs, likeness
from mctrack_ros.perception.local_tracks import LocalTracks, Prediction
from mctrack_ros.perception.partition import Bodies, Members, PartitionConfig, partition
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NEW = -1
COLUMNS = ('track', 'blob', 'box', 'foot', 'visible', 'proven', 'template', 'fitted')


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
    visible: Floats
    proven: Floats
    template: Floats
    fitted: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of persons."""
        return len(self.track)

    def select(self, index: NDArray[np.bool_] | NDArray[np.integer]) -> Observations:
        """Return the rows that a mask or an index array picks."""
        return Observations(*(getattr(self, name)[index] for name in COLUMNS))


def observe(
    blob_of: Ints,
    tracks: LocalTracks,
    predicted: Prediction,
    blobs: Blobs,
    template: Floats,
    image: NDArray[np.uint8],
    mask: NDArray[np.uint8],
    scale: float,
    sizes: SizeTable,
    blob_config: BlobConfig,
    config: PartitionConfig,
) -> Observations:
    """
    Tell persons from blobs: a blob of usual size is one, in others bodies are placed.

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
    image : (h, w, 3) uint8 array
        The picture, reduced by `scale`.
    mask : (h, w) uint8 array
        Its cleaned foreground.
    scale : float
        Pixels of the picture to one of the mask.
    sizes : SizeTable
        Of the camera.
    blob_config : BlobConfig
        A person's usual size.
    config : PartitionConfig
        Parameters.

    """
    count = np.bincount(blob_of[blob_of >= 0], minlength=len(blobs))
    whole = (count < 2) & _looks_like_one(blob_of, predicted, blobs, config)
    parts = [_whole(blob_of, blobs, template, np.flatnonzero(whole))]
    fits_one = _fits_one(blobs, config)
    for blob in np.flatnonzero(~whole).tolist():
        rows = np.flatnonzero(blob_of == blob)
        alike = likeness(predicted.box[rows], blobs.box[[blob]])[:, 0]
        if fits_one[blob] and alike.max(initial=0.0) < config.least_alike:
            parts.append(_whole(np.full(0, NEW), blobs, template, np.array([blob])))
            continue
        members = Members(
            predicted.bottom[rows],
            predicted.spread[rows],
            tracks.extent[rows],
            tracks.template[rows],
        )
        bodies = partition(
            image,
            mask,
            blobs.box[blob],
            scale,
            sizes,
            members,
            blob_config.person_height_m,
            config,
        )
        parts.append(_placed(bodies, blob, rows, sizes))
        if len(rows) and fits_one[blob]:
            parts[-1].proven[np.arange(len(bodies.proven)) != alike.argmax()] = 0.0
    seen = _stacked(parts)
    return seen.select(np.argsort(seen.blob, kind='stable'))


def _looks_like_one(
    blob_of: Ints, predicted: Prediction, blobs: Blobs, config: PartitionConfig
) -> NDArray[np.bool_]:
    """Tell which blobs, if they hold at most one track, look like one whole person."""
    matched = np.flatnonzero(blob_of >= 0)
    least = np.zeros(len(blobs))
    least[blob_of[matched]] = predicted.box[matched, 3]
    width, height = blobs.box[:, 2], blobs.box[:, 3]
    usual_width, usual_height = blobs.expected.T
    small = (width <= config.odd_width * usual_width) & (
        height <= config.odd_height * usual_height
    )
    not_halved = height * config.odd_height > np.minimum(least, usual_height)
    return np.asarray(blobs.truncated | (small & not_halved))


def _fits_one(blobs: Blobs, config: PartitionConfig) -> NDArray[np.bool_]:
    """Tell which blobs are no larger than one person: who else is in it must be hidden."""
    width, height = (blobs.box[:, 2:] / blobs.expected).T
    return np.asarray((width < config.single_width) & (height < config.odd_height))


def _whole(blob_of: Ints, blobs: Blobs, template: Floats, alone: Ints) -> Observations:
    """Return blobs that are one person each."""
    track_in = np.full(len(blobs), NEW)
    matched = np.flatnonzero(blob_of >= 0)
    track_in[blob_of[matched]] = matched
    one = np.ones(len(alone))
    return Observations(
        track_in[alone],
        alone,
        blobs.box[alone],
        blobs.foot[alone],
        one,
        one,
        template[alone],
        one == 0,
    )


def _placed(bodies: Bodies, blob: int, rows: Ints, sizes: SizeTable) -> Observations:
    count = len(bodies.box)
    track = np.full(count, NEW)
    track[: len(rows)] = rows
    return Observations(
        track,
        np.full(count, blob),
        bodies.box,
        sizes.foot_of(bodies.box),
        bodies.visible,
        bodies.proven,
        bodies.template,
        np.ones(count, bool),
    )


def _stacked(parts: list[Observations]) -> Observations:
    return Observations(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS)
    )
