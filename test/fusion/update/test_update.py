"""What a track learns of the detections that are its own, beside where it is."""

import numpy as np
import pytest

from fusion_scenes import detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.update import note
from mctrack_ros.interfaces import LARGEST_EXTENT, ClassCode

SECOND_NS = 1_000_000_000
PERSON, BICYCLE, VEHICLE = int(ClassCode.PERSON), int(ClassCode.BICYCLE), int(ClassCode.VEHICLE)
CONFIG = JointConfig()


def looks_of(seconds, camera=0, **columns):
    """Return an image, taken so many seconds after the start, of one detection."""
    stamp_ns = round((100 + seconds) * SECOND_NS)
    columns = {name: [value] for name, value in columns.items()}
    seen = detections(stamp_ns, [[0, 0]], **columns)
    return Batch([seen], [camera], stamp_ns, CONFIG)


def told(table, seconds, camera=0, **columns):
    batch = looks_of(seconds, camera, **columns)
    note(table, batch, np.zeros(1, np.int64), np.zeros(1, np.int64))


def test_who_saw_a_track_when_and_as_what_is_noted():
    table = TrackTable.blank(2, 3)
    rows = np.array([0, 1, 1])
    stamps = 100 * SECOND_NS + np.array([0, -5, -9])
    images = [detections(stamp, [[0, 0]]) for stamp in stamps]
    batch = Batch(images, [0, 1, 2], stamps[0], CONFIG)
    note(table, batch, rows, np.arange(3))
    assert table.cameras.tolist() == [0b001, 0b110]
    assert table.seen_ns.tolist() == table.kept_ns.tolist() == stamps[:2].tolist()
    assert table.seen_by_ns[rows, [0, 1, 2]].tolist() == stamps.tolist()


def test_a_size_is_taken_at_first_and_then_followed_over_eight_seconds():
    """By half at most; what cannot be a size tells nothing."""
    table = TrackTable.blank(1, 2)
    told(table, 0, extent=[0.6, np.nan])
    np.testing.assert_allclose(table.extent, [[0.6, np.nan]])
    told(table, 2, extent=[1.0, 1.8])
    np.testing.assert_allclose(table.extent, [[0.6 + 2 / 8 * 0.4, 1.8]], rtol=1e-6)
    told(table, 9, extent=[0.0, 1.4])
    np.testing.assert_allclose(table.extent, [[0.7, 1.6]], rtol=1e-6)
    told(table, 9, camera=1, extent=[LARGEST_EXTENT, -1.0])
    np.testing.assert_allclose(table.extent, [[0.7, 1.6]], rtol=1e-6)


@pytest.mark.parametrize(
    ('said', 'class_id', 'lead_s'),
    [
        ([(0, PERSON)], PERSON, 1.0),
        ([(0, PERSON), (0.25, PERSON)], PERSON, 1.25),
        ([(0, PERSON), (9, PERSON), (18, PERSON), (27, PERSON)], PERSON, 3.0),
        ([(0, PERSON), (9, PERSON), (18, PERSON), (18.25, PERSON)], PERSON, 3.0),
        ([(0, PERSON), (0.25, BICYCLE)], PERSON, 0.75),
        ([(0, PERSON), (0.25, 0)], PERSON, 1.0),
        ([(0, PERSON), (0.25, BICYCLE), (9, BICYCLE)], BICYCLE, 0.25),
        ([(0, BICYCLE)], BICYCLE, 1.0),
        ([(0, BICYCLE), (9, PERSON)], BICYCLE, 0.0),
        ([(0, BICYCLE), (9, PERSON), (9.5, PERSON)], PERSON, 0.5),
        ([(0, BICYCLE), (0.5, VEHICLE), (9, VEHICLE)], VEHICLE, 0.5),
    ],
)
def test_a_class_leads_by_how_long_it_was_said(said, class_id, lead_s):
    """A detection says it since that camera's last one, for 1 s at most; 3 s are a lead."""
    table = TrackTable.blank(1, 1)
    for seconds, kind in said:
        told(table, seconds, class_id=kind)
    assert table.class_id[0] == class_id
    assert table.class_lead_s[0] == pytest.approx(lead_s)
