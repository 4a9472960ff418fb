import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.reid.appearance import AppearanceModel, collect, samples
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.update import note
from mctrack_ros.interfaces import TEMPLATE_SIZE


def root(*bins, noise=0.0):
    mean = np.zeros(TEMPLATE_SIZE)
    mean[list(bins)] = 1 / np.sqrt(len(bins))
    return mean + noise


def learned(model, table, row, mean, seconds=5.0):
    table.sample[row], table.sample_s[row] = seconds * mean, seconds
    model.learn(table, row)


def test_by_what_everybody_differs_from_himself_is_not_told_apart():
    """Light changes bins 1 and 2 of everybody; bins 3 and 4 only by who it is."""
    rng, model, table = np.random.default_rng(1), AppearanceModel(), TrackTable.blank(2, 1)
    for _ in range(40):
        for row, own in ((0, 3), (1, 4)):
            light = np.zeros(TEMPLATE_SIZE)
            light[[1, 2]] = rng.normal(0, 0.1) * np.array([1, -1])
            learned(model, table, row, root(1, 2, own, noise=light))
    changed, other = np.zeros((2, TEMPLATE_SIZE))
    changed[[1, 2]] = other[[5, 6]] = 0.1, -0.1
    seen = np.stack([root(1, 2, 3, noise=each) for each in (changed, other)])
    by_light, by_colour = model.distances(seen, table.gallery[[0]])[:, 0]
    assert by_light < by_colour / 3


def test_a_gallery_is_the_mean_of_samples_and_follows_slow_change():
    model, table = AppearanceModel(), TrackTable.blank(1, 1)
    learned(model, table, 0, root(1), 1.0)
    learned(model, table, 0, root(2), 3.0)
    np.testing.assert_allclose(table.gallery[0], (root(1) + 3 * root(2)) / 4)
    assert (table.gallery_s[0], table.sample_s[0]) == (4.0, 0.0)
    for _ in range(40):
        learned(model, table, 0, root(3))
    assert np.abs(table.gallery[0] - root(3)).max() < 0.01


@pytest.fixture
def collected():
    """Add the colours of one detection, some seconds after the start, to those of a track."""
    table = TrackTable.blank(1, 1)

    def add(seconds, template, overlaps=False):
        stamp_ns = round(seconds * 1e9) + PERIOD_NS
        rows = detections(stamp_ns, [[0, 0]], template=[template])
        batch = Batch([rows], [0], stamp_ns, JointConfig())
        batch.is_overlapped[:] = overlaps
        pair = np.zeros(1, np.int64), np.zeros(1, np.int64)
        collect(table, batch, *pair)
        note(table, batch, *pair)
        return table

    return add


def test_colours_are_taken_at_first_and_then_mixed_in_over_a_time(collected):
    """By half at most; none tell nothing, and nobody's whose box overlaps another's."""
    first, second, nothing = *np.eye(2, TEMPLATE_SIZE), np.zeros(TEMPLATE_SIZE)
    for seconds, template, overlaps, expected in (
        (0, nothing, False, [0, 0]),
        (0.1, first, False, [1, 0]),
        (1.1, second, False, [0.875, 0.125]),
        (9, second, True, [0.875, 0.125]),
        (18, nothing, False, [0.875, 0.125]),
        (27, second, False, [0.4375, 0.5625]),
    ):
        table = collected(seconds, template, overlaps)
        np.testing.assert_allclose(table.template[0, :2], expected)


def test_a_sample_is_of_the_time_alone(collected):
    one, other = np.eye(2, TEMPLATE_SIZE)
    collected(0, one)
    table = collected(0.1, one)
    np.testing.assert_allclose(samples(table, np.array([0]))[0], one)
    table.in_contact[0], seconds = True, table.sample_s[0]
    collected(0.2, other)
    assert table.sample_s[0] == seconds
    table.sample[0] = table.sample_s[0] = 0.0
    np.testing.assert_allclose(samples(table, np.array([0])), np.sqrt(table.template))
