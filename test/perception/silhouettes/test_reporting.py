import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode, EventCode
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.events.groups import GroupConfig, Groups
from mctrack_ros.perception.silhouettes.features import SIZE, Shapes
from mctrack_ros.perception.silhouettes.objects import ObjectConfig, ObjectList
from mctrack_ros.perception.silhouettes.reporting import (
    ReportConfig,
    detections_of,
    note_arrivals,
    note_groups,
    passes,
)

PERIOD_NS = 250_000_000
APART, TOGETHER = np.array([-1, -1, -1]), np.array([4, 4, -1])


@pytest.fixture
def objects():
    """Return three established objects, the second one a vehicle."""
    known = ObjectList(ObjectConfig())
    box = np.array([[10.0, 10, 20, 60], [30, 20, 90, 50], [200, 10, 20, 60]])
    known.start(Shapes(np.ones((3, SIZE)), box), 0)
    known.established[:], known.travelled_px[:] = True, 40.0
    known.mean[:, :2], known.covariance[:] = [[1, 2], [3, 4], [5, 6]], np.eye(4)
    known.class_id[:] = ClassCode.PERSON, ClassCode.VEHICLE, ClassCode.PERSON
    return known


def noted(objects, components):
    """Return (image, event, local id) of what is noted in images in a row."""
    groups, events = Groups(GroupConfig(part_s=0.4)), []
    for index, component in enumerate(components):
        log = EventLog(index * PERIOD_NS)
        note_groups(groups, objects, component, index * PERIOD_NS, log)
        rows = log.rows()
        events += [
            (index, EventCode(code), int(key), others[others > 0].tolist())
            for code, key, others in zip(rows.event, rows.local_id, rows.others)
        ]
    return events


def test_who_shares_a_silhouette_has_merged_and_then_split(objects):
    events = noted(objects, [APART, TOGETHER, TOGETHER, APART, APART, APART])

    assert [event[:2] for event in events] == [(1, EventCode.MERGE), (4, EventCode.SPLIT)]
    assert all({key, *others} == {1, 2} for _, _, key, others in events)
    assert objects.group.tolist() == [0, 0, 0]


def test_one_image_apart_is_no_split(objects):
    events = noted(objects, [TOGETHER, APART, TOGETHER, APART, TOGETHER])

    assert [event[1] for event in events] == [EventCode.MERGE]
    assert objects.group.tolist() == [1, 1, 0]


def test_who_is_not_seen_stays_in_the_group(objects):
    noted(objects, [TOGETHER])
    objects.matched[:2] = False

    assert len(noted(objects, [TOGETHER] + [APART] * 8)) == 1


def test_an_arrival_is_noted_once(objects):
    objects.track_id[2] = 7
    first, second = EventLog(0), EventLog(PERIOD_NS)

    note_arrivals(objects, first)
    note_arrivals(objects, second)

    assert first.rows().event.tolist() == [EventCode.NEW, EventCode.NEW, EventCode.ENTER]
    assert len(second.rows()) == 0


def test_a_pedestrian_is_passed_on_after_three_seconds(objects):
    objects.coherent_ns[2] = 2 * PERIOD_NS

    assert passes(objects, 11 * PERIOD_NS, ReportConfig()).tolist() == [False, False, False]
    assert passes(objects, 12 * PERIOD_NS, ReportConfig()).tolist() == [True, False, False]
    assert passes(objects, 14 * PERIOD_NS, ReportConfig()).tolist() == [True, False, True]
    objects.travelled_px[2] = 18.0
    assert passes(objects, 14 * PERIOD_NS, ReportConfig()).tolist() == [True, False, False]


def test_detections_are_of_those_who_are_seen_and_stand_on_the_ground(objects):
    objects.matched[0] = False
    objects.mean[1, :2] = np.nan

    rows = detections_of(
        objects, np.full((3, 2), 1.5), np.zeros((3, 48)), np.zeros(3, np.bool_), 0, ReportConfig()
    )

    assert rows.local_id.tolist() == [3]
    assert rows.extent.tolist() == [[1.5, 1.5]]
    assert rows.class_id.tolist() == [ClassCode.PERSON]


def test_what_the_images_edge_cuts_off_is_of_unknown_size(objects):
    truncated = np.array([True, False, False])
    rows = detections_of(objects, np.ones((3, 2)), np.zeros((3, 48)), truncated, 0, ReportConfig())
    assert np.isnan(rows.extent).all(axis=1).tolist() == truncated.tolist()
