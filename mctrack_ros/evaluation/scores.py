"""The scores of a tracker, on the ground and in the image."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from mctrack_ros.evaluation.clear_mot import clear_mot, detection_scores
from mctrack_ros.evaluation.frames import Frame, box_distance, frames_of, ground_distance
from mctrack_ros.evaluation.hota import hota
from mctrack_ros.evaluation.trajectories import Trajectories


@dataclass(frozen=True, slots=True)
class Scores:
    """
    What a comparison with truth gave; NaN where there is nothing to divide by.

    Attributes
    ----------
    mota : float
        ``1 - (misses + false_positives + switches) / truth_rows`` with identity carried over
        from frame to frame (Bernardin and Stiefelhagen 2008).
    motp : float
        Closeness of the matched pairs, 0 to 1: mean of ``1 - distance / gate`` on the ground,
        mean IoU in the image.
    mean_distance : float
        Of the matched pairs: metres on the ground (the mean position error), 1 - IoU in the
        image.
    idf1, idp, idr : float
        Of the best one-to-one assignment of whole tracks (Ristani et al. 2016).
    hota, deta, assa, loca : float
        Higher order tracking accuracy and its parts (Luiten et al. 2021).
    moda, modp : float
        Detection alone, each frame matched for itself without identity (Kasturi et al. 2009);
        `modp` is to these matches what `motp` is to CLEAR MOT's.
    precision, recall : float
        Of the CLEAR MOT matches.
    switches, false_positives, misses, fragmentations : int
        CLEAR MOT counts.
    mostly_tracked, partially_tracked, mostly_lost : int
        True ids matched in at least 80 %, at least 20 %, less of their frames.
    frames, truth_ids, truth_rows, track_rows : int
        How much was compared.

    """

    mota: float
    motp: float
    mean_distance: float
    idf1: float
    idp: float
    idr: float
    hota: float
    deta: float
    assa: float
    loca: float
    moda: float
    modp: float
    precision: float
    recall: float
    switches: int
    false_positives: int
    misses: int
    fragmentations: int
    mostly_tracked: int
    partially_tracked: int
    mostly_lost: int
    frames: int
    truth_ids: int
    truth_rows: int
    track_rows: int

    def figures(self, prefix: str = '') -> dict[str, float]:
        """Return the scores by name, each with a prefix such as ``'pets.'``."""
        return {prefix + name: value for name, value in dataclasses.asdict(self).items()}


def evaluate_ground(truth: Trajectories, tracks: Trajectories, gate_m: float) -> Scores:
    """
    Compare positions on the ground plane.

    A pair can match up to and including the gate. HOTA's similarity falls from 1 to 0 at twice
    the gate, so that its threshold 0.5 is the gate (TrackEval's convention, 2 m there).

    Parameters
    ----------
    truth, tracks : Trajectories
        With positions.
    gate_m : float
        Largest Euclidean distance of a match, m.

    Raises
    ------
    ValueError
        If the gate is not positive or positions are missing.

    """
    if not gate_m > 0:
        raise ValueError(f'the gate is {gate_m!r} m, expected more than 0')
    _check_has(truth, tracks, 'position')
    frames = frames_of(truth, tracks, 'position', ground_distance, gate_m)
    return _scores(frames, gate_m, 2.0 * gate_m, gate_m)


def evaluate_boxes(truth: Trajectories, tracks: Trajectories, iou: float = 0.5) -> Scores:
    """
    Compare boxes in one camera's image.

    Parameters
    ----------
    truth, tracks : Trajectories
        With boxes.
    iou : float
        Least intersection over union of a match, 0 up to less than 1.

    Raises
    ------
    ValueError
        If the threshold is out of range or boxes are missing.

    """
    if not 0.0 <= iou < 1.0:
        raise ValueError(f'the IoU threshold is {iou!r}, expected 0 to less than 1')
    _check_has(truth, tracks, 'box')
    frames = frames_of(truth, tracks, 'box', box_distance, 1.0 - iou)
    return _scores(frames, 1.0 - iou, 1.0, 1.0)


def _scores(frames: Sequence[Frame], gate: float, zero_distance: float, unit: float) -> Scores:
    """Score frames; `unit` is the distance at which MOTP and MODP are zero."""
    identity = clear_mot(frames, gate)
    derived = {'motp': 1.0 - identity['mean_distance'] / unit, 'frames': len(frames)}
    without_identity = detection_scores(frames, gate, unit)
    return Scores(**identity | without_identity | hota(frames, zero_distance) | derived)


def _check_has(truth: Trajectories, tracks: Trajectories, geometry: str) -> None:
    for name, rows in (('truth', truth), ('tracks', tracks)):
        if len(rows) and not len(getattr(rows, geometry)):
            raise ValueError(f'{name} has no {geometry}')
