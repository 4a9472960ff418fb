"""Local tracks for members of groups whom the camera does not see, but the fusion node knows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.blob_split.single_blobs import ODD_HEIGHT, SINGLE_WIDTH
from mctrack_ros.perception.blobs.extraction import Blobs, overlap
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView
from mctrack_ros.perception.local_tracks.table import LocalTracks

Ints = NDArray[np.int64]
INSIDE_SHARE = 0.5
"""Share of the box where somebody is expected that must lie in the blob."""


def hidden_members(in_view: PersonsInView, part: Ints, tracked: Ints, blobs: Blobs) -> Ints:
    """
    Return the rows of persons in view, (k,), without a track in blobs of several.

    Parameters
    ----------
    in_view : PersonsInView
        Everybody in view.
    part : (n,) int64 array
        The part of the foreground each is in (see `contacts`); -1: not seen.
    tracked : (t,) int64 array
        Global ids of the local tracks, 0: none.
    blobs : Blobs
        Of the image.

    """
    rows = np.flatnonzero((in_view.local_id == 0) & (part >= 0))
    if len(rows):
        rows = rows[~(in_view.track_id[rows, None] == tracked).any(axis=1)]
    if not len(rows) or not len(blobs):
        return rows[:0]
    inside = overlap(in_view.box[rows], blobs.box)
    blob = inside.argmax(axis=1)
    width, height = (blobs.box[blob, 2:] / blobs.expected[blob]).T
    several = (width >= SINGLE_WIDTH) | (height >= ODD_HEIGHT)
    area = in_view.box[rows, 2] * in_view.box[rows, 3]
    return np.asarray(rows[several & (inside.max(axis=1) >= INSIDE_SHARE * area)], np.int64)


def begin_hidden(
    tracks: LocalTracks, in_view: PersonsInView, rows: Ints, feedback: Feedback, stamp_ns: int
) -> None:
    """
    Begin tracks where the fusion node expects some of the persons in view, (k,) rows.

    So they are looked for in the next image, near that place and in their colours, like members
    whom the camera has followed into the group (event-tracking paper, section 4.2: the server's
    feedback as a clue; R3 and R5). They are not reported until enough of them is visible.
    """
    if not len(rows):
        return
    box, track_id = in_view.box[rows], in_view.track_id[rows]
    target = (feedback.track_id == track_id[:, None]).argmax(axis=1)
    template = feedback.template[target].astype(np.float64)
    noise = tracks.foot_noise(box)
    new = tracks.start(in_view.position[rows], box, noise, template, stamp_ns)
    tracks.mean[new, 2:] = feedback.velocity[target]
    tracks.covariance[new] = feedback.covariance[target]
    tracks.track_id[new], tracks.confirmed[new] = track_id, True
