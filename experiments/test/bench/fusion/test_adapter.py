import numpy as np

from mctrack_experiments.bench.fusion.adapter import CoreTracker, told_config
from mctrack_experiments.bench.fusion.true_association import TrueAssociation


def test_fusion_finds_nearly_all_targets_of_a_base_scene(toolkit, scene):
    measured = toolkit.measure({'fusion': CoreTracker(scene.scenario)}, 50)['fusion']
    assert len(measured.milliseconds) == 50
    assert toolkit.score(scene, measured.reported).mota > 0.9


def test_fusion_is_told_what_every_tracker_is(scene):
    config = told_config(scene.scenario)
    assert config.association.false_density == scene.scenario.sensors.clutter_density
    assert config.batching.period == scene.scenario.tick_s


def test_true_association_follows_every_target(toolkit, scene):
    measured = toolkit.measure({'true': TrueAssociation(scene)}, 50)['true']
    score = toolkit.score(scene, measured.reported)
    assert (score.mota, score.idf1, score.switches) == (1.0, 1.0, 0)
    assert score.motp < 0.15
    assert np.isfinite(measured.reported[-1][1]).all()
