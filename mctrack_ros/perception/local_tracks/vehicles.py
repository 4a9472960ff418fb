"""Vehicles and bicycles among the blobs of the default tracker: one object each, however large."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import ClassCode, Feedback
from mctrack_ros.perception.blob_split.measurements import Observations
from mctrack_ros.perception.blobs.extraction import BlobConfig, Blobs, describe, overlap
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.classification import (
    BICYCLE_LENGTH_M,
    ClassConfig,
    ClassVotes,
    looks_like_bicycle,
    looks_like_vehicle,
)
from mctrack_ros.perception.local_tracks.table import LocalTracks

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

BICYCLE_HEIGHT_M = 1.7  # of people on bicycles: about as on foot
PIECE_SHARE = 0.5
"""Share of a blob's box, where fusion expects a vehicle, from which it is a piece of that."""
PROVEN_S = 0.3
"""What has looked like something for so long is that, also in a blob as large as a vehicle, s."""


class Vehicles:
    """
    Tells vehicles and bicycles from people by size, and lets them stand where they do.

    Parameters
    ----------
    config : ClassConfig
        What makes a vehicle.
    come : bool
        Whether there are any; else all are people.
    blobs : BlobConfig
        A person's usual size.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(
        self,
        config: ClassConfig,
        come: bool,
        blobs: BlobConfig,
        sizes: SizeTable,
        mapping: GroundMapping,
    ) -> None:
        self._config, self._may_come, self._blobs = config, come, blobs
        self._usual = np.array([blobs.person_width_m, blobs.person_height_m])
        self._sizes, self._mapping = sizes, mapping
        self._votes = ClassVotes()

    def whole(self, blobs: Blobs, feedback: Feedback | None, stamp_ns: int) -> Blobs:
        """
        Join the pieces of each vehicle that fusion knows to one blob.

        Of a car as grey as the ground an image shows windows, wheels and a shadow.

        Parameters
        ----------
        blobs : Blobs
            Of an image.
        feedback : Feedback or None
            The fusion node's.
        stamp_ns : int
            Time of the image, ns.

        """
        if not self._may_come or feedback is None or not len(blobs):
            return blobs
        expected = self._expected(feedback, stamp_ns)
        share = overlap(blobs.box, expected) / blobs.box[:, 2:].prod(axis=1)[:, None]
        piece, vehicle = (share >= PIECE_SHARE).nonzero()
        if not len(piece):
            return blobs
        part = np.arange(len(blobs)) + len(expected)
        part[piece] = vehicle
        box, area = _united(blobs, np.unique(part, return_inverse=True)[1])
        order = np.lexsort(box.T[::-1])  # from left to right
        return describe(box[order], area[order], self._mapping, self._sizes, self._blobs)[0]

    def _expected(self, feedback: Feedback, stamp_ns: int) -> Floats:
        """Return the boxes, (n, 4) px, from roof to near end, of vehicles that are in view."""
        known = feedback.extent[:, 0] >= self._config.vehicle_width_m
        place, extent = feedback.places(stamp_ns)[known], feedback.extent[known].astype(float)
        box = self._sizes.box_of(self._mapping.image_from_ground(place), extent)
        along = np.hypot(*self._mapping.image_jacobian(place)[:, 1].T)
        box[:, 3] += along * extent[:, 0] / 2
        return box[np.isfinite(box).all(axis=1)]

    def heights(self, blobs: Blobs, blob_of: Ints, tracks: LocalTracks) -> Floats:
        """
        Return how tall the vehicle or bicycle is that each blob is, (n,) m; 0: it is none.

        Parameters
        ----------
        blobs : Blobs
            Of an image.
        blob_of : (t,) int array
            Row of the blob that each track is in; -1: none.
        tracks : LocalTracks
            The tracks.

        """
        height = np.zeros(len(blobs))
        if not self._may_come:
            return height
        inside = (blob_of >= 0).nonzero()[0]
        speed = np.full(len(blobs), -1.0)
        np.maximum.at(speed, blob_of[inside], self._speed(tracks)[inside])
        extent = self._extent(blobs)
        look = self._look(blobs, extent, speed)
        kind, lead = self._votes.leads(tracks.local_id)
        short = extent[:, 0] <= BICYCLE_LENGTH_M
        bicycle = bicycles_among(blob_of, kind, tracks.confirmed, look, short)
        height[bicycle] = BICYCLE_HEIGHT_M
        vehicle = vehicles_among(blob_of, kind, lead, look, blobs.truncated)
        height[vehicle] = self._config.vehicle_height_m
        return height

    def stand(self, tracks: LocalTracks, seen: Observations, rows: Mask, blobs: Blobs) -> None:
        """
        Let the tracks of some who are seen, (n,) rows, stand in the middle of their ground.

        Who turns out to be a person stands at his feet again; what is cut off shows neither.
        """
        if not self._may_come:
            return
        chosen = np.flatnonzero(rows & ~seen.fitted & ~blobs.truncated[seen.blob])
        track = seen.track[chosen]
        covers = seen.depth[chosen].any(axis=1) | tracks.near_px[track].any(axis=1)
        if covers.any():
            chosen = chosen[covers]
            tracks.stand(seen.track[chosen], seen.position[chosen], seen.foot[chosen])

    def classify(
        self, tracks: LocalTracks, seen: Observations, blobs: Blobs, seconds: float
    ) -> None:
        """Let the tracks that are seen as a whole, and alone, say what they are by their size."""
        if not self._may_come:
            tracks.class_id[:] = ClassCode.PERSON
            return
        shown = ~(seen.fitted | blobs.truncated[seen.blob])
        track, blob = seen.track[shown], seen.blob[shown]
        speed = np.full(len(blobs), -1.0)
        speed[blob] = self._speed(tracks)[track]
        look, whole = np.zeros(len(tracks), np.int64), np.zeros(len(tracks), np.bool_)
        look[track] = self._look(blobs, self._extent(blobs), speed)[blob]
        whole[track] = True
        kind = self._votes.count(tracks.local_id, look, whole, seconds)
        _, lead = self._votes.leads(tracks.local_id)
        new = (lead >= PROVEN_S) | ((lead > 0.0) & (tracks.class_id == ClassCode.UNKNOWN))
        tracks.class_id[new] = kind[new]

    def _look(self, blobs: Blobs, extent: Floats, speed: Floats) -> Ints:
        """Return the `ClassCode` that each blob looks like, (n,), so large, m, and fast, m/s."""
        fill = blobs.area / blobs.box[:, 2:].prod(axis=1)
        bicycle = looks_like_bicycle(extent, fill, speed)
        vehicle = looks_like_vehicle(extent, self._config)
        is_large = np.where(vehicle, ClassCode.VEHICLE, ClassCode.PERSON)
        return np.where(bicycle, ClassCode.BICYCLE, is_large)

    def _extent(self, blobs: Blobs) -> Floats:
        """Return the (n, 2) widths and heights of blobs, m, as if upright."""
        return np.asarray(blobs.box[:, 2:] / blobs.expected * self._usual)

    @staticmethod
    def _speed(tracks: LocalTracks) -> Floats:
        return np.asarray(np.hypot(tracks.mean[:, 2], tracks.mean[:, 3]))


def vehicles_among(blob_of: Ints, kind: Ints, lead: Floats, look: Ints, truncated: Mask) -> Mask:
    """
    Tell which blobs are one vehicle: what is as large as one, and no group of people.

    People who meet were seen apart, a vehicle comes as a whole: through the edge of the image,
    as one track that never looked like a person or a bicycle.

    Parameters
    ----------
    blob_of : (t,) int array
        Row of the blob that each track is in; -1: none.
    kind, lead : (t,) int and float arrays
        Of the tracks, see `ClassVotes.leads`.
    look : (n,) int array
        `ClassCode` that each blob looks like.
    truncated : (n,) bool array
        Which blobs touch the image's edge.

    """
    large = look == ClassCode.VEHICLE
    vehicle = kind == ClassCode.VEHICLE
    people = _holding(blob_of, ~vehicle & (lead >= PROVEN_S), len(look)) > 0
    known = _holding(blob_of, vehicle & (lead > 0.0), len(look)) > 0
    return np.asarray(np.where(known, large | truncated, large & ~truncated & ~people))


def bicycles_among(blob_of: Ints, kind: Ints, confirmed: Mask, look: Ints, short: Mask) -> Mask:
    """
    Return which blobs are one bicycle: of its size, or one before, and with nobody else in them.

    Parameters
    ----------
    blob_of, kind, look : (t,), (t,) and (n,) int arrays
        See `vehicles_among`.
    confirmed : (t,) bool array
        Which tracks are confirmed.
    short : (n,) bool array
        Which blobs are no longer than a bicycle.

    """
    known = _holding(blob_of, kind == ClassCode.BICYCLE, len(look)) > 0
    alone = _holding(blob_of, confirmed, len(look)) < 2
    return np.asarray(alone & ((known & short) | (look == ClassCode.BICYCLE)))


def _holding(blob_of: Ints, some: Mask, count: int) -> Ints:
    """Return how many of some tracks, (t,), each of the blobs holds."""
    return np.bincount(blob_of[some & (blob_of >= 0)], minlength=count)


def _united(blobs: Blobs, part: Ints) -> tuple[Floats, Floats]:
    """Return the boxes (k, 4) and areas (k,) of parts, each of the blobs with its number (n,)."""
    low, high = np.full((2, part.max() + 1, 2), [[[np.inf]], [[-np.inf]]])
    np.minimum.at(low, part, blobs.box[:, :2])
    np.maximum.at(high, part, blobs.box[:, :2] + blobs.box[:, 2:])
    return np.hstack([low, high - low]), np.bincount(part, blobs.area).astype(float)
