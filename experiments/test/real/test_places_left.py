"""Places that people have left, on masks that are known to the pixel."""

import numpy as np
import pytest

from mctrack_experiments.datasets.epfl_terrace import PERIOD_NS
from mctrack_experiments.real.foreground.places_left import boxes_at, overlap, places_left, shares
from mctrack_ros.codec.camera_messages import png_from_foreground
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Foreground
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.simulation import Scenario
from mctrack_ros.simulation.cameras import looking_at

MAPPING = ProjectiveMapping(
    looking_at('c0', (3, -12, 6), (3, 4, 0), 800.0, Scenario(width=360, height=288)).matrix,
    (360, 288),
)


def masks(shade_s):
    """Yield a person who leaves after 2 s, and whose place stays foreground for so long."""
    box = np.round(boxes_at(MAPPING, np.array([[3.0, 4.0]]))[0] / 4).astype(int)
    for frame in range(1, 25 * 50, 25):
        mask = np.zeros((72, 90), np.uint8)
        if frame < 25 * (2 + shade_s):
            mask[box[1] : box[3], box[0] : box[2]] = 255
        yield Foreground(frame * PERIOD_NS, mask)


@pytest.mark.parametrize('shade_s', [0, 60])
def test_what_stays_foreground_after_somebody_left_is_told(tmp_path, shade_s):
    with BagWriter(tmp_path / 'bag') as writer:
        for each in masks(shade_s):
            message = png_from_foreground(each, ROSBAGS_CLASSES, 'c0')
            writer.write('/c0/foreground/compressed', message, each.stamp_ns)
    frames = np.arange(1, 25 * 50, 25)
    people = np.where(frames[:, None] < 50, [3.0, 4.0], [6.5, 9.0])
    truth = Trajectories(frames, np.ones(len(frames), int), people)
    found = places_left(tmp_path / 'bag', {'c0': MAPPING}, truth, 0)
    assert (found['left'] > 0.1) == (shade_s > 0)
    assert found['left'] == 0 or shade_s


def test_shares_and_overlaps_are_those_of_boxes():
    mask = np.zeros((10, 10), np.uint8)
    mask[:5] = 255
    boxes = np.array([[0, 0, 4, 10], [0, 5, 4, 10], [8, 0, 12, 4], [np.nan, 0, 1, 1]])
    np.testing.assert_array_equal(shares(mask, boxes), [0.5, 0, np.nan, np.nan])
    touching = overlap(boxes[:2], np.array([[4.0, 0, 6, 10], [3, 6, 6, 9]]))
    np.testing.assert_array_equal(touching, [[False, True], [False, True]])
