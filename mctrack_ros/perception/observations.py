"""What of a picture belongs to which local track: blobs, and bodies in shared blobs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.blobs import BlobConfig, Blobs, expected_size, likeness_of_pairs
from mctrack_ros.perception.local_tracks import LocalTracks, Prediction
from mctrack_ros.perception.partition import Members, PartitionConfig, partition
from mctrack_ros.perception.picture import Picture
from mctrack_ros.perception.sizes import SizeTable
from mctrack_ros.tracking.appearance import Palette

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
        rows = np.flatnonzero(blob_of >= 0)
        inside = blob_of[rows]
        box = predicted.box[rows]
        looks_like_one = self._looks_like_one(inside, box, blobs)
        whole = looks_like_one & (np.bincount(inside, minlength=len(blobs)) < 2)
        single = ~whole & self._fits_one(blobs)
        most_alike, best = _best(inside, rows, box, blobs)
        strange = single & (most_alike < self._config.least_alike)
        track_in = np.where(strange, NEW, best)
        parts = [_whole(track_in, blobs, template, np.flatnonzero(whole | strange))]
        shared = np.flatnonzero(~(whole | strange))
        if len(shared):
            part = self._placed(shared, blob_of, tracks, predicted, blobs, picture)
            part.proven[single[part.blob] & (part.track != best[part.blob])] = 0.0
            parts.append(part)
        return self._on_ground(parts, tracks, blobs)

    def _looks_like_one(self, inside: Ints, box: Floats, blobs: Blobs) -> NDArray[np.bool_]:
        """Tell which blobs, if they hold at most one track, look like one whole person."""
        least = np.zeros(len(blobs))
        least[inside] = box[:, 3]
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

    def _placed(
        self,
        shared: Ints,
        blob_of: Ints,
        tracks: LocalTracks,
        predicted: Prediction,
        blobs: Blobs,
        picture: Picture,
    ) -> _Part:
        """Place the tracks that are in some blobs, and new persons, in these."""
        number = np.full(len(blobs) + 1, NEW)
        number[shared] = np.arange(len(shared))
        rows = np.argsort(number[blob_of], kind='stable')
        rows = rows[np.count_nonzero(number[blob_of] == NEW) :]
        members = Members(
            number[blob_of[rows]],
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
        return _Part(
            track,
            shared[bodies.blob],
            bodies.box,
            bodies.visible,
            bodies.proven,
            bodies.template,
            np.ones(len(track), bool),
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
        tall = expected_size(foot, self._sizes, self._blobs)[:, 1]
        near_enough = tall >= self._blobs.farthest_height_px  # so below the horizon, too
        return seen.select(np.isfinite(position).all(axis=1) & near_enough)


def _best(inside: Ints, rows: Ints, box: Floats, blobs: Blobs) -> tuple[Floats, Ints]:
    """
    Return how alike each blob and the track in it are that is most so, and that track's row.

    Of tracks (k,), ``inside`` tells the blobs, ``rows`` the rows, ``box`` where they are expected.
    """
    alike = likeness_of_pairs(box, blobs.box[inside])
    most, best = np.zeros(len(blobs)), np.full(len(blobs), NEW)
    np.maximum.at(most, inside, alike)
    is_best = (alike == most[inside])[::-1]
    best[inside[::-1][is_best]] = rows[::-1][is_best]
    return most, best


def _whole(track_in: Ints, blobs: Blobs, template: Floats, alone: Ints) -> _Part:
    """Return blobs that are one person each."""
    one = np.ones(len(alone))
    return _Part(track_in[alone], alone, blobs.box[alone], one, one, template[alone], one == 0)
