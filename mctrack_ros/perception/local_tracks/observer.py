"""What of an image belongs to which local track: blobs, and bodies in shared blobs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.blob_split.measurements import Footing, Observations, footed, gathered
from mctrack_ros.perception.blob_split.single_blobs import members_of, single_blobs
from mctrack_ros.perception.blob_split.split import partition
from mctrack_ros.perception.blobs.extraction import BlobConfig, Blobs
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.geometry.ground_extent import ground_depth
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import FilterConfig, LocalTracks, Prediction

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Observer:
    """
    Finds persons in blobs: a blob of one person's size is one, in others bodies are placed.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    sizes : SizeTable
        Of the camera.
    blobs : BlobConfig
        A person's usual size.
    filtering : FilterConfig
        How well feet are seen.

    """

    def __init__(
        self,
        mapping: GroundMapping,
        sizes: SizeTable,
        blobs: BlobConfig,
        filtering: FilterConfig,
    ) -> None:
        self._mapping, self._sizes = mapping, sizes
        self._footing = Footing(
            filtering.foot_noise_px,
            filtering.foot_noise_share,
            blobs.person_height_m,
            blobs.farthest_height_px,
        )

    def observe(
        self,
        blob_of: Ints,
        tracks: LocalTracks,
        predicted: Prediction,
        blobs: Blobs,
        template: Floats,
        frame: Frame,
        height_m: Floats,
    ) -> Observations:
        """
        Return who is in the blobs of an image, by blob; nobody at the horizon or above it.

        Parameters
        ----------
        blob_of : (t,) int64 array
            Row of the blob that each track is in; -1: none.
        tracks : LocalTracks
            The camera's tracks.
        predicted : Prediction
            Where they are expected.
        blobs : Blobs
            Of the image.
        template : (n, 48) array
            Colours of the blobs.
        frame : Frame
            With its foreground.
        height_m : (n,) array
            How tall the vehicle or bicycle is that a blob is, m; 0: it is none.

        """
        by_size = single_blobs(
            blob_of,
            predicted.box,
            blobs.box,
            blobs.expected,
            blobs.truncated,
            height_m > 0.0,
        )
        shared = np.flatnonzero(~by_size.alone)
        rows, members = members_of(
            shared, blob_of, predicted.box, predicted.spread, tracks.extent, tracks.template
        )
        bodies = partition(
            frame,
            blobs.box[shared],
            self._sizes,
            members,
            self._footing.height_m,
        )
        seen = gathered(by_size, bodies, shared, rows, blobs.box, template)
        return self._on_ground(seen, blobs, height_m, tracks.noise_ratio)

    def _on_ground(
        self, seen: Observations, blobs: Blobs, height_m: Floats, noise_ratio: Floats
    ) -> Observations:
        """Look up where the feet of persons stand; leave out who stands nowhere."""
        foot, noise, near = footed(
            seen,
            self._sizes.table,
            blobs.truncated,
            blobs.expected,
            blobs.box,
            noise_ratio,
            self._footing,
        )
        position = np.ascontiguousarray(self._mapping.ground_from_image(foot))
        near &= np.isfinite(position[:, 0]) & np.isfinite(position[:, 1])
        seen = seen._replace(foot=foot, position=position, noise=noise)
        large = (height_m[seen.blob] > 0.0) & near
        if large.any():
            box, height = seen.box[large], height_m[seen.blob[large]]
            seen.depth[large] = ground_depth(box, height, self._sizes, self._mapping)
            position += seen.depth / 2
        return seen.select(near)
