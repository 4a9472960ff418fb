"""Why one tick was decided as it was: who was weighed against what, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.rows import POSITION, Column, Rows

UNKNOWN = float('nan')


@dataclass(frozen=True, eq=False, slots=True)
class Candidates(Rows):
    """
    What was weighed in one tick, one row a pair of a track and a detection.

    Costs are minus twice the logarithm of a likelihood ratio, "this track's" against "nobody's";
    a pair's are ``squared_distance + clutter + appearance + belief + doubt``. They are
    NaN where nothing was weighed: where a detection hides a track, begins one or is nobody's.

    Attributes
    ----------
    position : (n, 3) float32 array
        The detection, m.
    covariance : (n, 2, 2) float32 array
        Of it, as it was used: with the error that all detections have, m².
    expected : (n, 2) float32 array
        Where the image was to show the track: by prediction and all other images, m.
    expected_covariance : (n, 2, 2) float32 array
        Of that, m².
    squared_distance : (n,) float32 array
        Squared Mahalanobis distance; the gate is its limit.
    clutter : (n,) float32 array
        Of false detections in an area as large as the uncertainty.
    appearance : (n,) float32 array
        Of colours: how they differ.
    doubt : (n,) float32 array
        Of a track that is not confirmed.
    probability : (n,) float32 array
        With which the pair was used.
    seconds : (n,) float32 array
        From the tick's stamp to the image's, s; not above 0.
    track_id : (n,) uint32 array
        The track, by its id after the tick; 0: none.
    local_id, told_id : (n,) uint32 arrays
        What the camera calls the detection, and whom it takes it for; 0: nothing.
    detection : (n,) uint32 array
        Row in the camera's message.
    camera : (n,) uint16 array
        Index in the site's order.
    choice : (n,) uint8 array
        A `Choice`.
    member_count : (n,) uint8 array
        As the detection's.

    """

    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'covariance': Column('f4', (2, 2)),
        'expected': Column('f4', (2,), UNKNOWN),
        'expected_covariance': Column('f4', (2, 2), UNKNOWN),
        'squared_distance': Column('f4', (), UNKNOWN),
        'clutter': Column('f4', (), UNKNOWN),
        'appearance': Column('f4', (), UNKNOWN),
        'doubt': Column('f4', (), UNKNOWN),
        'probability': Column('f4'),
        'seconds': Column('f4'),
        'track_id': Column('u4'),
        'local_id': Column('u4'),
        'told_id': Column('u4'),
        'detection': Column('u4'),
        'camera': Column('u2'),
        'choice': Column('u1'),
        'member_count': Column('u1', (), 1),
    }

    position: NDArray[np.float32]
    covariance: NDArray[np.float32]
    expected: NDArray[np.float32]
    expected_covariance: NDArray[np.float32]
    squared_distance: NDArray[np.float32]
    clutter: NDArray[np.float32]
    appearance: NDArray[np.float32]
    doubt: NDArray[np.float32]
    probability: NDArray[np.float32]
    seconds: NDArray[np.float32]
    track_id: NDArray[np.uint32]
    local_id: NDArray[np.uint32]
    told_id: NDArray[np.uint32]
    detection: NDArray[np.uint32]
    camera: NDArray[np.uint16]
    choice: NDArray[np.uint8]
    member_count: NDArray[np.uint8]

    @property
    def cost(self) -> NDArray[np.float32]:
        """What each pair costs in all, (n,)."""
        weighed = self.appearance + self.doubt
        return np.asarray(self.squared_distance + self.clutter + weighed, np.float32)


@dataclass(frozen=True, eq=False, slots=True)
class Decisions(Rows):
    """
    What one tick made of every track, those that ended included, one row each.

    Attributes
    ----------
    position : (n, 3) float32 array
        After the tick, m.
    covariance : (n, 2, 2) float32 array
        Of it, m².
    predicted : (n, 2) float32 array
        Before its detections, m; NaN for one that begins.
    predicted_covariance : (n, 2, 2) float32 array
        Of that, m².
    velocity : (n, 2) float32 array
        After the tick, m/s.
    age, unseen, unsupported : (n,) float32 arrays
        Since its first detection; since the last one of its own; since the last one of its own or
        of its group, s.
    evidence : (n,) float32 array
        Log-odds of being a target.
    value, limit : (n,) float32 arrays
        What the reason was judged by, see `Reason`; NaN where by nothing.
    track_id, previous_id : (n,) uint32 arrays
        What it is called after the tick, and what it was called before where that changed.
    other_id : (n,) uint32 array
        The other track that the reason is about; 0: none.
    group : (n,) uint32 array
        Smallest id of the group that it is in; 0: none.
    cameras : (n,) uint32 array
        Bits of the cameras that saw it.
    status : (n,) uint8 array
        A `TrackStatus`.
    reason : (n,) uint8 array
        A `Reason`.
    missed : (n,) float32 array
        Log-odds of having gone, as no camera has seen it, though they could have.
    is_published : (n,) uint8 array
        1 if it or its end is published, 0 if it is only remembered.

    """

    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'covariance': Column('f4', (2, 2)),
        'predicted': Column('f4', (2,), UNKNOWN),
        'predicted_covariance': Column('f4', (2, 2), UNKNOWN),
        'velocity': Column('f4', (2,)),
        'age': Column('f4'),
        'unseen': Column('f4'),
        'unsupported': Column('f4'),
        'evidence': Column('f4'),
        'value': Column('f4', (), UNKNOWN),
        'limit': Column('f4', (), UNKNOWN),
        'track_id': Column('u4'),
        'previous_id': Column('u4'),
        'other_id': Column('u4'),
        'group': Column('u4'),
        'cameras': Column('u4'),
        'status': Column('u1'),
        'reason': Column('u1'),
        'missed': Column('f4', absent=0.0),
        'is_published': Column('u1', (), 1, absent=1),
    }

    position: NDArray[np.float32]
    covariance: NDArray[np.float32]
    predicted: NDArray[np.float32]
    predicted_covariance: NDArray[np.float32]
    velocity: NDArray[np.float32]
    age: NDArray[np.float32]
    unseen: NDArray[np.float32]
    unsupported: NDArray[np.float32]
    evidence: NDArray[np.float32]
    value: NDArray[np.float32]
    limit: NDArray[np.float32]
    track_id: NDArray[np.uint32]
    previous_id: NDArray[np.uint32]
    other_id: NDArray[np.uint32]
    group: NDArray[np.uint32]
    cameras: NDArray[np.uint32]
    status: NDArray[np.uint8]
    reason: NDArray[np.uint8]
    missed: NDArray[np.float32]
    is_published: NDArray[np.uint8]


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """
    Why a tick was decided as it was.

    Attributes
    ----------
    candidates : Candidates
        What was weighed, sorted by track, camera, time and detection.
    decisions : Decisions
        What came of it, sorted by track.

    """

    candidates: Candidates
    decisions: Decisions

    @property
    def stamp_ns(self) -> int:
        """Of the tick, ns."""
        return self.decisions.stamp_ns
