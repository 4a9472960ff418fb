"""What a camera reports of its objects: detections, events, and which pedestrians go to fusion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.interfaces import ClassCode, Detections, EventCode
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.groups import Groups
from mctrack_ros.perception.silhouettes.features import AREA, Floats, Ints
from mctrack_ros.perception.silhouettes.objects import ObjectList


@dataclass(frozen=True)
class ReportConfig:
    """Parameters of what is reported."""

    coherent_s: float = parameter(
        3.0,
        'how long a pedestrian is tracked without a gap before it is reported [s]',
        minimum=0.0,
    )
    travel_px: float = parameter(
        20.0,
        'least distance that it has travelled by then; 0: none, as in the paper [px]',
        minimum=0.0,
    )
    part_s: float = parameter(
        0.4, 'how long objects must be apart before a split is reported [s]', minimum=0.0
    )


@dataclass(frozen=True, eq=False, slots=True)
class TrackedObjects:
    """
    The objects of one image, for evaluation; one row each.

    Attributes
    ----------
    local_id : (n,) int64 array
        Never reused.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    class_id : (n,) int64 array
        A `ClassCode`: person or vehicle.
    established : (n,) bool array
        No longer transient.
    matched : (n,) bool array
        Seen in this image.
    passed_on : (n,) bool array
        A pedestrian tracked coherently for long enough, now or before.

    """

    local_id: Ints
    box: Floats
    class_id: Ints
    established: NDArray[np.bool_]
    matched: NDArray[np.bool_]
    passed_on: NDArray[np.bool_]


def note_groups(
    groups: Groups, objects: ObjectList, component: Ints, stamp_ns: int, log: EventLog
) -> None:
    """
    Note when objects begin to share a silhouette (E5) and when they no longer do (E3).

    Parameters
    ----------
    groups : Groups
        Remembers who shared one.
    objects : ObjectList
        Whose ``group`` is changed.
    component : (n,) int array
        Connected component that each object shares with others; -1: none.
    stamp_ns : int
        Time of the image, ns.
    log : EventLog
        Takes the events.

    """
    rows = np.flatnonzero(objects.established)
    own = len(objects) + component.max(initial=0) + np.arange(len(objects))
    part = np.where(component >= 0, component, np.where(objects.matched, own, -1))
    for change in groups.step(objects.local_id[rows], part[rows], stamp_ns):
        first = int(np.searchsorted(objects.local_id, change.part[0]))
        others = np.array([*change.part[1:], *change.rest], np.int64)
        log.add(EventCode.MERGE if change.merged else EventCode.SPLIT, objects, first, others)
    objects.group[:] = 0
    for number, members in enumerate(groups.members(), start=1):
        objects.group[np.isin(objects.local_id, members)] = number


def note_arrivals(objects: ObjectList, log: EventLog) -> None:
    """Note objects that are no longer transient: new (E1) or known to the fusion node (E2)."""
    for row in np.flatnonzero(objects.established & ~objects.announced).tolist():
        known = objects.track_id[row] > 0
        log.add(EventCode.ENTER if known else EventCode.NEW, objects, row)
    objects.announced |= objects.established


def passes(objects: ObjectList, stamp_ns: int, config: ReportConfig) -> NDArray[np.bool_]:
    """Tell which pedestrians, (n,), have been tracked coherently for long enough by now."""
    coherent = (stamp_ns - objects.coherent_ns) * 1e-9 >= config.coherent_s - 1e-6
    came = coherent & (objects.travelled_px >= config.travel_px)
    return np.asarray(
        objects.established & objects.matched & came & (objects.class_id == ClassCode.PERSON)
    )


def detections_of(
    objects: ObjectList,
    extent: Floats,
    template: Floats,
    truncated: NDArray[np.bool_],
    stamp_ns: int,
    config: ReportConfig,
) -> Detections:
    """
    Return one row for each established object that is seen and stands on the ground.

    Parameters
    ----------
    objects : ObjectList
        After this image.
    extent : (n, 2) array
        Widths and heights that their boxes have on the ground, m.
    template : (n, 48) array
        Their colours.
    truncated : (n,) bool array
        Which touch the image's edge.
    stamp_ns : int
        Time of the image, ns.
    config : ReportConfig
        Parameters.

    """
    reported = objects.established & objects.matched & np.isfinite(objects.mean[:, :2]).all(axis=1)
    reported &= np.isfinite(objects.covariance[:, :2, :2]).all(axis=(1, 2))
    rows = np.flatnonzero(reported)
    age = (stamp_ns - objects.coherent_ns[rows]) * 1e-9
    return Detections.build(
        stamp_ns,
        position=np.column_stack([objects.mean[rows, :2], np.zeros(len(rows))]),
        covariance=objects.covariance[rows, :2, :2],
        box=objects.box[rows],
        area=objects.vector[rows, AREA],
        score=np.clip(age / max(config.coherent_s, 1e-9), 0.1, 1.0),
        extent=np.where(truncated[rows, None], np.nan, extent[rows]),
        template=template[rows],
        local_id=objects.local_id[rows],
        track_id=objects.track_id[rows],
        truncated=truncated[rows],
        class_id=objects.class_id[rows],
    )
