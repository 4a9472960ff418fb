import functools

import numpy as np
import pytest

from mctrack_experiments.datasets.cmc import AREA, load_cmc
from mctrack_experiments.datasets.stored import (
    StoredScene,
    disturbed,
    feet_to_detections,
    inside,
)
from mctrack_experiments.datasets.wildtrack import load_wildtrack, load_wildtrack_boxes
from mctrack_experiments.real.stored import detections as stored_detections
from mctrack_experiments.real.stored.detections import (
    by_passage,
    reproduce_cmc,
    reproduce_lab6p,
    reproduce_pets_multiview,
)
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.boxes import BodyModel

IMAGE_FROM_WORLD = np.array([[800.0, 0, 320], [0, 800.0, 240], [0, 0, 1]]) @ np.array(
    [[1.0, 0, 0, 0], [0, -0.5, -np.sqrt(0.75), 2.0], [0, np.sqrt(0.75), -0.5, 6.0]]
)


def test_points_above_the_ground_are_put_below_where_they_are():
    mapping = ProjectiveMapping(IMAGE_FROM_WORLD, (640, 480))
    places = np.array([[0.0, 0.5], [1.0, 2.0], [-1.5, 3.0]])
    ankles = mapping.image_from_ground(places, 0.1)
    found = feet_to_detections(ankles, mapping, 5, 1.0, height=0.1)
    np.testing.assert_allclose(found.position[:, :2], places, atol=1e-5)
    assert feet_to_detections(ankles, mapping, 5, 1.0).position[1, 1] > 2.1


def test_who_is_away_for_longer_than_allowed_comes_back_as_somebody_new():
    frame = np.array([9, 0, 3, 2, 0])  # 1 is away for two frames, then for five
    ids = np.array([1, 1, 1, 2, 2])
    tracks = Trajectories(frame=frame, id=ids, position=np.zeros((5, 2)))
    passage = by_passage(tracks, 2).id
    assert passage[1] == passage[2] != passage[0]
    assert passage[3] == passage[4] not in passage[:3]


def test_what_lies_on_an_area_s_edge_is_inside():
    position = np.array([[1.0, -2.0], [3.0, 5.0], [0.9, 0.0], [2.0, 5.1]])
    assert inside(position, ((1.0, 3.0), (-2.0, 5.0))).tolist() == [True, True, False, False]


def test_a_scene_is_disturbed_by_its_seed_and_by_no_more_than_asked():
    rows = Detections.build(7, position=np.zeros((500, 3)), score=np.ones(500))
    nobody = Trajectories(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 2)))
    scene = StoredScene(np.arange(1), 4.0, {'east': [rows]}, nobody)
    one, same, other = (disturbed(scene, 0.02, seed).detections['east'][0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.position, same.position)
    assert (one.position[:, :2] != other.position[:, :2]).all()
    assert one.position[:, :2].std() == pytest.approx(0.02, rel=0.1)
    assert (one.position[:, 2] == 0).all()
    assert (rows.position == 0).all()


def first_half(scene):
    """Return the first half of a scene."""
    frame = scene.frame[: len(scene.frame) // 2]
    detections = {camera: rows[: len(frame)] for camera, rows in scene.detections.items()}
    truth = scene.truth.select(scene.truth.frame <= frame[-1])
    return StoredScene(frame, scene.rate, detections, truth)


@pytest.mark.real_data
def test_lab6p_four_cameras_beat_any_one(data_root, monkeypatch):
    load = stored_detections.load_lab6p
    monkeypatch.setattr(stored_detections, 'load_lab6p', lambda *each: first_half(load(*each)))
    figures = reproduce_lab6p(data_root).figures
    assert figures['lab6p.moda'] >= 0.93
    assert figures['lab6p.moda'] > figures['lab6p.best_single.moda']


@pytest.fixture(scope='module')
def cmc():
    """Return `load_cmc`, which loads nothing twice."""
    return functools.cache(load_cmc)


@pytest.mark.real_data
def test_cmc_is_tracked(data_root, cmc, monkeypatch):
    monkeypatch.setattr(stored_detections, 'load_cmc', cmc)
    monkeypatch.setattr(stored_detections, 'SEEDS', (1, 2))
    figures = reproduce_cmc(data_root).figures
    assert figures['cmc1.mota'] >= 0.9
    assert figures['cmc2.moda'] >= 0.92
    assert figures['cmc2.mota'] >= 0.86
    assert figures['cmc2.disturbed.mota'] >= 0.86
    assert figures['cmc2.disturbed.mota_deviation'] < 0.05


@pytest.mark.real_data
def test_pets_six_views_are_tracked(data_root):
    figures = reproduce_pets_multiview(data_root).figures
    assert figures['pets.multiview.mota'] >= 0.85
    assert figures['pets.multiview.all_frames.moda'] >= 0.92
    assert figures['pets.multiview.by_passage.moda'] == figures['pets.multiview.moda']
    assert figures['pets.multiview.by_passage.idf1'] >= figures['pets.multiview.idf1'] + 0.03


@pytest.mark.real_data
def test_detections_outside_the_room_are_dropped(data_root, cmc):
    scene = cmc(data_root / 'cmc_4cam', 1, BodyModel())
    positions = np.concatenate([one.position for one in scene.detections['cam4']])
    assert inside(positions.astype(float), AREA).all()


@pytest.mark.real_data
def test_wildtrack_detections_lie_near_the_truth(data_root):
    scene = load_wildtrack(data_root / 'wildtrack', 'proposed_confirmed', 10.0)
    assert len(scene.frame) == len(set(scene.truth.frame.tolist())) == 360
    near = []
    for index in range(0, 360, 20):
        truth = scene.truth.position[scene.truth.frame == index]
        for rows in scene.detections.values():
            gap = rows[index].position[:, None, :2] - truth
            near += np.linalg.norm(gap, axis=2).min(axis=1, initial=9.0).tolist()
    assert np.median(near) < 0.35


def test_wildtrack_boxes_stand_at_the_annotated_places_in_no_order_of_people(data_root):
    scene = load_wildtrack_boxes(data_root / 'wildtrack', 2.0)
    near, sorts = [], []
    for index in range(0, 360, 20):
        truth = scene.truth.select(scene.truth.frame == index)
        for rows in scene.detections.values():
            gap = np.linalg.norm(rows[index].position[:, None, :2] - truth.position, axis=2)
            near += gap.min(axis=1, initial=9.0).tolist()
            sorts.append(np.diff(truth.id[gap.argmin(axis=1)]))
    assert np.quantile(near, 0.95) < 0.25
    assert 0.3 < np.mean(np.concatenate(sorts) > 0) < 0.7
