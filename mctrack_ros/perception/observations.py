"""What of a picture belongs to which local track: blobs, and bodies in shared blobs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.blobs import BlobConfig, Blobs
from mctrack_ros.perception.local_tracks import LocalTracks, Prediction
from mctrack_ros.perception.matching import Matches
from mctrack_ros.perception.partition import Bodies, Members, PartitionConfig, partition
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NEW = -1
COLUMNS = ('track', 'blob', 'box', 'foot', 'visible', 'proven', 'fitted')


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
    fitted : (n,) bool array
        A body was placed in the blob; else the blob is the person.

    """

    track: Ints
    blob: Ints
    box: Floats
    foot: Floats
    visible: Floats
    proven: Floats
    fitted: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of persons."""
        return len(self.track)

    def select(self, mask: NDArray[np.bool_]) -> Observations:
        """Return the rows that a mask picks."""
        return Observations(*(getattr(self, name)[mask] for name in COLUMNS))


def observe(
    matches: Matches,
    tracks: LocalTracks,
    predicted: Prediction,
    blobs: Blobs,
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
    matches : Matches
        Which tracks are in which blobs.
    tracks : LocalTracks
        The camera's tracks.
    predicted : Prediction
        Where they are expected.
    blobs : Blobs
        Of the picture.
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
    parts = []
    for blob, rows in enumerate(_tracks_in(matches, len(blobs))):
        if len(rows) < 2 and _is_one(blobs, blob, predicted.box[rows], config):
            parts.append(_whole(blobs, blob, rows))
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
        if len(rows) and _fits_one(blobs, blob, config):
            parts[-1].proven[1:] = 0.0
    return _stacked(parts)


def _tracks_in(matches: Matches, count: int) -> list[Ints]:
    """Return the rows of the tracks in each blob."""
    inside = [np.zeros(0, np.int64)] * count
    for row, blob in zip(matches.single_track, matches.single_blob):
        inside[blob] = np.array([row])
    for rows, blob in zip(matches.group_tracks, matches.group_blob):
        inside[blob] = rows
    return inside


def _is_one(blobs: Blobs, blob: int, predicted: Floats, config: PartitionConfig) -> bool:
    """Whether a blob with at most one track looks like one whole person."""
    width, height = blobs.box[blob, 2:]
    usual_width, usual_height = blobs.expected[blob]
    if blobs.truncated[blob]:
        return True
    if width > config.odd_width * usual_width or height > config.odd_height * usual_height:
        return False
    return not len(predicted) or bool(
        height * config.odd_height > min(predicted[0, 3], usual_height)
    )


def _fits_one(blobs: Blobs, blob: int, config: PartitionConfig) -> bool:
    """Whether a blob is no larger than one person: who else is in it must be hidden."""
    width, height = blobs.box[blob, 2:] / blobs.expected[blob]
    return bool(width < config.single_width and height < config.odd_height)


def _whole(blobs: Blobs, blob: int, rows: Ints) -> Observations:
    track = rows if len(rows) else np.array([NEW])
    part = slice(blob, blob + 1)
    return Observations(
        track,
        np.array([blob]),
        blobs.box[part],
        blobs.foot[part],
        np.ones(1),
        np.ones(1),
        np.zeros(1, bool),
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
        np.ones(count, bool),
    )


def _stacked(parts: list[Observations]) -> Observations:
    empty = Observations(
        np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 4)), np.zeros((0, 2)),
        np.zeros(0), np.zeros(0), np.zeros(0, bool),
    )  # fmt: skip
    every = [empty, *parts]
    return Observations(
        *(np.concatenate([getattr(part, name) for part in every]) for name in COLUMNS)
    )
