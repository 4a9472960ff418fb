"""What of a picture belongs to which local track: blobs, and bodies in shared blobs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.blobs import BlobConfig, Blobs, likeness
from mctrack_ros.perception.local_tracks import LocalTracks, Prediction
from mctrack_ros.perception.partition import Bodies, Members, PartitionConfig, partition
from mctrack_ros.perception.picture import Picture
from mctrack_ros.perception.sizes import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NEW = -1


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


@dataclass(frozen=True, eq=False, slots=True)
class _Part:
    """Some rows of what becomes `Observations`; the same attributes."""

    track: Ints
    blob: Ints
    box: Floats
    visible: Floats
    proven: Floats
    template: Floats
    fitted: NDArray[np.bool_]


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

    """

    def __init__(
        self,
        mapping: GroundMapping,
        sizes: SizeTable,
        blobs: BlobConfig,
        config: PartitionConfig,
    ) -> None:
        self._mapping, self._sizes = mapping, sizes
        self._blobs, self._config = blobs, config

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
        Return the persons in the blobs of a picture, by blob; none above the horizon.

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
        count = np.bincount(blob_of[blob_of >= 0], minlength=len(blobs))
        whole = (count < 2) & self._looks_like_one(blob_of, predicted, blobs)
        parts = [_whole(blob_of, blobs, template, np.flatnonzero(whole))]
        fits_one = self._fits_one(blobs)
        for blob in np.flatnonzero(~whole).tolist():
            rows = np.flatnonzero(blob_of == blob)
            if fits_one[blob]:
                alike = likeness(predicted.box[rows], blobs.box[[blob]])[:, 0]
                if alike.max(initial=0.0) < self._config.least_alike:
                    parts.append(_whole(np.full(0, NEW), blobs, template, np.array([blob])))
                    continue
            bodies = self._partition(blob, rows, tracks, predicted, blobs, picture)
            parts.append(_placed(bodies, blob, rows))
            if len(rows) and fits_one[blob]:
                parts[-1].proven[np.arange(len(bodies.proven)) != alike.argmax()] = 0.0
        return self._on_ground(parts, tracks, blobs)

    def _looks_like_one(
        self, blob_of: Ints, predicted: Prediction, blobs: Blobs
    ) -> NDArray[np.bool_]:
        """Tell which blobs, if they hold at most one track, look like one whole person."""
        matched = np.flatnonzero(blob_of >= 0)
        least = np.zeros(len(blobs))
        least[blob_of[matched]] = predicted.box[matched, 3]
        width, height = blobs.box[:, 2], blobs.box[:, 3]
        usual_width, usual_height = blobs.expected.T
        small = (width <= self._config.odd_width * usual_width) & (
            height <= self._config.odd_height * usual_height
        )
        not_halved = height * self._config.odd_height > np.minimum(least, usual_height)
        return np.asarray(blobs.truncated | (small & not_halved))

    def _fits_one(self, blobs: Blobs) -> NDArray[np.bool_]:
        """Tell which blobs are no larger than one person: who else is in it must be hidden."""
        width, height = (blobs.box[:, 2:] / blobs.expected).T
        return np.asarray((width < self._config.single_width) & (height < self._config.odd_height))

    def _partition(
        self,
        blob: int,
        rows: Ints,
        tracks: LocalTracks,
        predicted: Prediction,
        blobs: Blobs,
        picture: Picture,
    ) -> Bodies:
        """Place the tracks of some rows, and new persons, in a blob."""
        members = Members(
            predicted.bottom[rows],
            predicted.spread[rows],
            tracks.extent[rows],
            tracks.template[rows],
        )
        usual_height_m = self._blobs.person_height_m
        return partition(
            picture, blobs.box[blob], self._sizes, members, usual_height_m, self._config
        )

    def _on_ground(self, parts: list[_Part], tracks: LocalTracks, blobs: Blobs) -> Observations:
        """Join the parts, by blob, and look up where the feet stand."""
        order = np.argsort(np.concatenate([part.blob for part in parts]), kind='stable')
        track, blob, box, visible, proven, template, fitted = (
            np.concatenate([getattr(part, name) for part in parts])[order]
            for name in _Part.__slots__
        )
        foot = self._sizes.foot_of(box)
        position = self._mapping.ground_from_image(foot)
        noise = tracks.foot_noise(box)
        hidden = 1 / np.minimum(np.maximum(visible, self._config.least_visible), 1.0)
        noise *= np.where(fitted, hidden**2, 1.0)[:, None, None]
        missing = np.maximum(blobs.expected[blob] - blobs.box[blob, 2:], 0.0)
        missing[~blobs.truncated[blob]] = 0.0
        noise[:, [0, 1], [0, 1]] += missing**2
        seen = Observations(
            track, blob, box, foot, position, noise, visible, proven, template, fitted
        )
        return seen.select(np.isfinite(position).all(axis=1) & self._sizes.known_at(foot))


def _whole(blob_of: Ints, blobs: Blobs, template: Floats, alone: Ints) -> _Part:
    """Return blobs that are one person each."""
    track_in = np.full(len(blobs), NEW)
    matched = np.flatnonzero(blob_of >= 0)
    track_in[blob_of[matched]] = matched
    one = np.ones(len(alone))
    return _Part(track_in[alone], alone, blobs.box[alone], one, one, template[alone], one == 0)


def _placed(bodies: Bodies, blob: int, rows: Ints) -> _Part:
    """Return bodies in a blob, first those of known tracks."""
    count = len(bodies.box)
    track = np.full(count, NEW)
    track[: len(rows)] = rows
    return _Part(
        track,
        np.full(count, blob),
        bodies.box,
        bodies.visible,
        bodies.proven,
        bodies.template,
        np.ones(count, bool),
    )
