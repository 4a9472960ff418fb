import numpy as np
import pytest

from mctrack_experiments.papers.belief.protocol import ONE_VIEW, compared, kept
from mctrack_experiments.papers.belief.scenes import HIDDEN_BELOW, Kind, scripted


@pytest.fixture(scope='module', params=[False, True], ids=['static', 'ptz'])
def scene(request):
    return scripted(1, request.param, rate_hz=12.5)


def test_there_are_twenty_occlusions_of_four_kinds(scene):
    kinds = [each.kind for each in scene.occlusions]
    assert {kind: kinds.count(kind) for kind in Kind} == dict.fromkeys(Kind, 5)
    assert {each.target for each in scene.occlusions} == set(range(5))


def test_targets_are_hidden_where_the_script_says(scene):
    for each in scene.occlusions:
        first, last = scene.hidden(each)
        assert last > first, each
        clearest = scene.visible[first:last, :, each.target].min(axis=0)
        for camera in each.cameras:
            assert clearest[camera] < HIDDEN_BELOW, each
        for camera in {0, 1} - set(each.cameras):
            assert np.median(scene.visible[first:last, camera, each.target]) > 0.5


def test_targets_stay_in_both_views_and_walk(scene):
    in_view = scene.world.feet_in_view[:, :, scene.persons]
    assert in_view.all()
    velocity = scene.world.motion.velocity[:, scene.persons]
    assert np.linalg.norm(velocity, axis=2).max() < 4


def test_the_seed_decides():
    one, same, other = (scripted(seed, rate_hz=5) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.truth, same.truth)
    assert one.occlusions == same.occlusions
    assert one.occlusions != other.occlusions


def test_frames_hold_both_cameras(scene):
    cameras, images = next(scene.frames())
    assert set(cameras) == set(images)
    assert all(image.shape == (576, 768, 3) for image in images.values())
    assert scene.visible[0].max(axis=0).min() > 0


def test_the_truth_keeps_everybody_and_a_team_mates_path_nobody(scene):
    assert all(values.all() for values in kept(scene, scene.truth).values())
    away = scene.truth + np.array([1.5, 0])
    assert not any(values.any() for values in kept(scene, away).values())
    assert not any(values.any() for values in kept(scene, np.full_like(away, np.nan)).values())
    with pytest.raises(ValueError, match='shape'):
        kept(scene, scene.truth[:, :2])


def test_only_the_time_after_the_occlusion_counts(scene):
    hidden = scene.occlusions[0]
    tracks = scene.truth.copy()
    first, last = scene.hidden(hidden)
    tracks[first:last, hidden.target] += 5
    assert all(values.all() for values in kept(scene, tracks).values())
    tracks[last:, hidden.target] += 5
    assert not kept(scene, tracks)[hidden.kind].all()


def test_figures_have_intervals_over_seeds_and_paired_leads():
    rng = np.random.default_rng(5)

    def runs(rate):
        return [{kind: rng.random(5) < rate for kind in Kind} for _ in range(20)]

    figures = compared({'belief': runs(0.97), 'central': runs(0.5)}, 'belief')
    assert figures['belief.kept.low'] <= figures['belief.kept'] <= figures['belief.kept.high']
    assert figures['lead.central'] == pytest.approx(
        figures['belief.kept'] - figures['central.kept']
    )
    assert figures['lead.central.low'] > 0
    assert set(ONE_VIEW) == set(Kind) - {Kind.BOTH_VIEWS}
