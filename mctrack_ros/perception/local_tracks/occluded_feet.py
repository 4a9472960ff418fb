"""Places where something of the scene hides feet: learned, and feet found by the head there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BOOLS_1D,
    FLOATS_1D,
    FLOATS_2D,
    FLOATS_3D,
    INTS_1D,
    compiled,
    inner,
)
from mctrack_ros.perception.blob_split.measurements import OBSERVATIONS, Observations
from mctrack_ros.perception.blob_split.single_blobs import NEW
from mctrack_ros.perception.blobs.extraction import shared_area
from mctrack_ros.perception.geometry.person_size import foot_below, metre_at
from mctrack_ros.perception.local_tracks.table import LocalTracks

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CELLS = 48, 24
"""Rows and columns of cells, into which an image is divided."""

KNOWN_S = 1.0
"""For so long somebody must have been seen alone for his height to be known, s."""

SHORT = 0.88
"""A silhouette shorter than this share of its person's height lacks a part."""

WHOLE = 0.94
"""One longer than this share is whole."""

SHORT_TELLS = 0.1
"""Weight of a shortened silhouette in the height."""

WALKING = 0.5
"""A slower person may have bent down or sat down, m/s."""

AWAY_NS = 2_000_000_000
"""Return to a place after this time counts as another passage, ns."""

SURE = 2
"""Surplus of passages without visible feet from which a cell hides feet."""

FORGETFUL = 4
"""Limit of the count, so that changes of the scene are learned."""

ROUNDS = 3
"""Iterations of the foot point and the size of a metre there."""


class Places(NamedTuple):
    """
    What is known of the cells of an image in which feet are, or would be.

    Attributes
    ----------
    balance : (r, c) int64 array
        How many more have passed without feet than with them.
    tally : (r, c) int64 array
        The same of the images of the last one who passed, or still does: he counts when another
        one comes, or he himself comes back.
    passer : (r, c) int64 array
        His local id.
    last_ns : (r, c) int64 array
        When he was there, ns.

    """

    balance: Ints
    tally: Ints
    passer: Ints
    last_ns: Ints


PLACES = types.NamedUniTuple(types.i8[:, ::1], 4, Places)


class OccludedFeet:
    """
    Learns where feet are hidden, and finds them there.

    The silhouette of one who walks may be shorter than he is known to be because he runs or is
    badly seen; but where all who pass are short, something of the scene stands before their feet.
    There these are looked for below the head, by the height that is remembered, or a usual one.
    What others hide is not learned from, and left to `partition`.

    Parameters
    ----------
    size : (int, int)
        Width and height of the image, px.
    usual_m : float
        Height of a person who is not known, m.
    memory_s : float
        Time constant of the heights that are remembered, s.

    """

    def __init__(self, size: tuple[int, int], usual_m: float, memory_s: float) -> None:
        self._cell = np.array([size[0] / CELLS[1], size[1] / CELLS[0]])
        self._usual_m, self._memory_s = usual_m, memory_s
        self._places = Places(*(np.zeros(CELLS, np.int64) for _ in Places._fields))

    def reach(
        self,
        seen: Observations,
        blob_box: Floats,
        whole: Booleans,
        sizes: Floats,
        predicted: Floats,
        tracks: LocalTracks,
        stamp_ns: int,
        seconds: float,
    ) -> None:
        """
        Let the boxes of persons whose feet are hidden reach down to them, and learn.

        Parameters
        ----------
        seen : Observations
            The persons; boxes and shares that are visible are changed in place.
        blob_box, whole : (m, 4) and (m,) bool arrays
            Of the blobs: boxes, px, and which are neither cut off by the edge nor vehicles.
        sizes : (r, c, 4) array
            The camera's `SizeTable.table`.
        predicted : (t, 4) array
            Boxes of the tracks, px.
        tracks : LocalTracks
            The camera's; how tall they are is changed in place.
        stamp_ns, seconds : int, float
            Time of the image, ns, and since the last one, s.

        """
        if len(seen.track):
            _reach(
                seen, blob_box, whole, sizes, predicted, tracks.local_id, tracks.mean,
                tracks.height_m, tracks.height_s, stamp_ns, seconds, self._memory_s,
                self._usual_m, self._cell, self._places,
            )  # fmt: skip


@inner
def _reaching_down(sizes: Floats, box: Floats, height_m: float) -> Floats:
    """Return the box, (4,) px, of the same top whose height is so much at its own foot."""
    whole = box.copy()
    for _ in range(ROUNDS):
        x, y = foot_below(sizes, whole[0], whole[1], whole[2], whole[3])
        whole[3] = height_m * metre_at(sizes, x, y)[1]
    return whole


@inner
def _meets_others(box: Floats, boxes: Floats, own: int) -> bool:
    """Tell whether a box, (4,), meets any of some, (n, 4), but one of them."""
    met = 0
    for row in range(len(boxes)):
        met += row != own and shared_area(box, boxes[row]) > 0.0
    return met > 0


@inner
def _note_passing(
    places: Places,
    row: int,
    column: int,
    local_id: int,
    is_short: bool,
    walks: bool,
    stamp_ns: int,
) -> None:
    """Count an image of one who passes a cell; at his first, the one before him."""
    balance, tally, passer, last_ns = places
    if passer[row, column] != local_id or stamp_ns - last_ns[row, column] > AWAY_NS:
        passed = balance[row, column] + (tally[row, column] > 0) - (tally[row, column] < 0)
        balance[row, column] = min(max(passed, -FORGETFUL), FORGETFUL)
        tally[row, column], passer[row, column] = 0, local_id
    last_ns[row, column] = stamp_ns
    if walks:
        tally[row, column] += 1 if is_short else -1
    elif is_short:  # he has bent down or sat down, perhaps when he came
        tally[row, column] = min(tally[row, column], 0)


@inner
def _remember(
    height_m: Floats, height_s: Floats, track: int, shown_m: float, seconds: float, memory_s: float
) -> None:
    """Let a height follow what is shown of it, the more slowly, the longer it is known."""
    telling_s = seconds * (SHORT_TELLS if shown_m < SHORT * height_m[track] else 1.0)
    height_s[track] = min(height_s[track] + telling_s, memory_s)
    share = min(telling_s / max(height_s[track], 1e-9), 1.0)
    height_m[track] += share * (shown_m - height_m[track])


@compiled(
    types.void(
        OBSERVATIONS, FLOATS_2D, BOOLS_1D, FLOATS_3D, FLOATS_2D, INTS_1D, FLOATS_2D,
        types.f8[::1], types.f8[::1], types.i8, types.f8, types.f8, types.f8, FLOATS_1D, PLACES,
    )
)  # fmt: skip
def _reach(
    seen: Observations, blob_box: Floats, whole: Booleans, sizes: Floats, predicted: Floats,
    local_id: Ints, mean: Floats, height_m: Floats, height_s: Floats, stamp_ns: int,
    seconds: float, memory_s: float, usual_m: float, cell: Floats, places: Places,
) -> None:  # fmt: skip
    """See `OccludedFeet.reach`."""
    persons = np.zeros(len(blob_box), np.int64)
    for blob in seen.blob:
        persons[blob] += 1
    for row, track in enumerate(seen.track):
        blob = seen.blob[row]
        if persons[blob] > 1 or not whole[blob]:
            continue
        box = blob_box[blob]
        is_known = track != NEW and height_s[track] >= KNOWN_S
        lower = _reaching_down(sizes, box, height_m[track] if is_known else usual_m)
        if _meets_others(lower, blob_box, blob) or _meets_others(lower, predicted, track):
            continue
        x, y = foot_below(sizes, lower[0], lower[1], lower[2], lower[3])
        down, right = int(y / cell[1]), int(x / cell[0])
        if not (0 <= down < CELLS[0] and 0 <= right < CELLS[1]):
            continue
        visible = box[3] / lower[3]
        if is_known and (visible < SHORT or visible > WHOLE):
            walks = np.hypot(mean[track, 2], mean[track, 3]) >= WALKING
            short = visible < SHORT
            _note_passing(places, down, right, local_id[track], short, walks, stamp_ns)
        about = 0 if is_known else 1  # rows: an unknown height tells less well where feet are
        most = places.balance[down, right]
        for near in range(max(down - about, 0), min(down + about + 1, CELLS[0])):
            most = max(most, places.balance[near, right])
        if visible < WHOLE and most >= SURE:
            seen.visible[row] = visible
            for side in range(4):
                seen.box[row, side] = lower[side]
        elif track != NEW:
            x, y = foot_below(sizes, box[0], box[1], box[2], box[3])
            shown_m = box[3] / metre_at(sizes, x, y)[1]
            _remember(height_m, height_s, track, shown_m, seconds, memory_s)
