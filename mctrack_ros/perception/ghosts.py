"""Foreground that is a hole in the background: someone left who was taken for background."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.blobs import likeness

Image = NDArray[np.uint8]
MARGIN = 3
KERNEL = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class GhostConfig:
    """Parameters of `GhostWatch`."""

    period_s: float = parameter(0.2, 'time between searches [s]', minimum=0.0)
    patience_s: float = parameter(
        1.0, 'time that something must look like a ghost in one place [s]', minimum=0.0
    )
    settling_s: float = parameter(
        4.0, 'time from the first background in which ghosts are usual: none is waited for [s]',
        minimum=0.0,
    )  # fmt: skip
    same_share: float = parameter(
        0.7,
        'share of two boxes (intersection over union) from which they are one place',
        minimum=0.0,
        maximum=1.0,
    )
    edge_ratio: float = parameter(
        1.25,
        "times that the background's edges along an outline exceed the picture's",
        minimum=1.0,
    )
    edge_difference: float = parameter(
        6.0, 'and by how much they do at least [grey levels]', minimum=0.0
    )


class GhostWatch:
    """
    Finds ghosts among persons and puts the picture into the background there.

    Along a real object's outline the picture has edges, along a ghost's the background model; and
    a ghost stays where it is, while texture may make whoever passes look like one for a moment.

    Parameters
    ----------
    config : GhostConfig
        Parameters.

    """

    def __init__(self, config: GhostConfig) -> None:
        self._config = config
        self.restart()

    def restart(self) -> None:
        """Forget all suspicion."""
        self._box = np.zeros((0, 4))
        self._since_ns = np.zeros(0, np.int64)
        self._first_ns: int | None = None
        self._next_ns = 0

    def look(
        self, model: Image, image: Image, mask: Image, box: NDArray[np.floating], stamp_ns: int
    ) -> NDArray[np.bool_]:
        """
        Look at persons, if it is time again, and heal what has long looked like a ghost.

        Parameters
        ----------
        model : (h, w, 3) uint8 array
            Background; changed in place where a ghost is.
        image : (h, w, 3) uint8 array
            Picture.
        mask : (h, w) uint8 array
            Foreground.
        box : (n, 4) array
            Persons to look at: left, top, width, height in pixels of these pictures.
        stamp_ns : int
            Time of the picture, ns.

        Returns
        -------
        (n,) bool array
            Which were healed.

        """
        healed = np.zeros(len(box), np.bool_)
        if stamp_ns < self._next_ns:
            return healed
        self._next_ns = stamp_ns + round(self._config.period_s * 1e9)
        cells = np.rint(box).astype(int)
        suspicious = np.array(
            [self._is_suspicious(model, image, mask, row) for row in cells], bool
        )
        since = self._suspected_since(box, stamp_ns)
        healed = suspicious & (stamp_ns - since >= self._patience_ns(stamp_ns))
        for row in cells[healed]:
            part = _around(row)
            hole = cv2.dilate(mask[part], KERNEL, iterations=MARGIN - 1)
            cv2.copyTo(image[part], hole, model[part])
        waiting = suspicious & ~healed
        self._box, self._since_ns = box[waiting].astype(np.float64), since[waiting]
        return healed

    def _patience_ns(self, stamp_ns: int) -> int:
        if self._first_ns is None:
            self._first_ns = stamp_ns
        settled = stamp_ns - self._first_ns >= round(self._config.settling_s * 1e9)
        return round(self._config.patience_s * 1e9) if settled else 0

    def _suspected_since(self, box: NDArray[np.floating], stamp_ns: int) -> NDArray[np.int64]:
        """Return since when something has been suspected at the places of boxes, ns."""
        if not len(self._box):
            return np.full(len(box), stamp_ns, np.int64)
        same = likeness(box.astype(np.float64), self._box) >= self._config.same_share
        since: NDArray[np.int64] = np.where(same, self._since_ns[None], stamp_ns).min(axis=1)
        return since

    def _is_suspicious(
        self, model: Image, image: Image, mask: Image, box: NDArray[np.integer]
    ) -> bool:
        part = _around(box)
        outline = cv2.morphologyEx(mask[part], cv2.MORPH_GRADIENT, KERNEL)
        in_image, in_model = (_edges(picture[part], outline) for picture in (image, model))
        return bool(
            in_model > self._config.edge_ratio * in_image
            and in_model - in_image > self._config.edge_difference
        )


def _around(box: NDArray[np.integer]) -> tuple[slice, slice]:
    left, top, width, height = box.tolist()
    return (
        slice(max(top - MARGIN, 0), top + height + MARGIN),
        slice(max(left - MARGIN, 0), left + width + MARGIN),
    )


def _edges(picture: Image, outline: cv2.typing.MatLike) -> float:
    """Return the mean gradient, grey levels, along an outline."""
    gradient = cv2.morphologyEx(picture, cv2.MORPH_GRADIENT, KERNEL)
    return float(sum(cv2.mean(gradient, outline)[:3]) / 3)
