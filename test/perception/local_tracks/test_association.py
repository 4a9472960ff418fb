from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from mctrack_ros.perception.blobs.extraction import BlobConfig, describe
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.association import SIZE_WEIGHT, MatchingConfig, match
from mctrack_ros.perception.local_tracks.table import FilterConfig, LocalTracks

RED, BLUE = np.eye(48)[0], np.eye(48)[20]


@pytest.fixture
def scene(mapping):
    """Match confirmed tracks at some places to blobs at others, with their colours."""
    sizes = SizeTable(mapping)

    def boxes(places):
        foot = mapping.image_from_ground(places)
        return sizes.box_of(foot, np.tile([0.6, 1.75], (len(foot), 1)))

    def tracked(places, template=None):
        tracks = LocalTracks(FilterConfig(), mapping, sizes)
        box = boxes(places)
        known = np.zeros((len(box), 48)) if template is None else np.array(template)
        places = np.array(places, float).reshape(-1, 2)
        tracks.start(places, box, tracks.foot_noise(box), known, 0)
        tracks.confirmed[:] = True
        return tracks

    def described(boxes):
        return describe(boxes, np.prod(boxes[:, 2:], axis=1), mapping, sizes, BlobConfig())[0]

    def matched(tracks_at, blobs, colours=None, template=None):
        tracks = tracked(tracks_at, template)
        seen = np.zeros((len(blobs), 48)) if colours is None else np.array(colours)
        return match(tracks, tracks.prediction(), described(blobs), seen, MatchingConfig())

    matched.boxes, matched.tracked, matched.described = boxes, tracked, described
    return matched


def test_each_track_takes_its_blob(scene):
    blob_of = scene([(0, 0), (3, 1)], scene.boxes([(3.1, 1.0), (0.1, 0.0)]))
    assert blob_of.tolist() == [1, 0]


def test_blob_far_from_all_tracks_is_free(scene):
    assert scene([(0, 0)], scene.boxes([(4.0, 4.0)])).tolist() == [-1]


def test_track_whose_box_lies_in_a_shared_blob_joins_the_group(scene):
    first, second = scene.boxes([(0.0, 0.0), (0.6, 0.1)])
    low = np.minimum(first[:2], second[:2])
    high = np.maximum(first[:2] + first[2:], second[:2] + second[2:])
    blob_of = scene([(0, 0), (0.6, 0.1)], np.concatenate([low, high - low])[None])
    assert blob_of.tolist() == [0, 0]


def test_colours_decide_between_equally_near_blobs(scene):
    blobs = scene.boxes([(-0.15, 0.0), (0.15, 0.0)])
    assert scene([(0, 0), (0, 0)], blobs, [RED, BLUE], [BLUE, RED]).tolist() == [1, 0]


@pytest.mark.parametrize('seed', range(8))
def test_blobs_are_shared_out_as_is_likeliest(scene, seed):
    """Of all ways to do it, by numpy's distances, determinants and logarithms of heights."""
    rng = np.random.default_rng(seed)
    config = MatchingConfig(gate=1000.0)
    blobs = scene.described(scene.boxes(rng.uniform(-0.3, 0.3, (3, 2))))
    tracks = scene.tracked(rng.uniform(-0.3, 0.3, (5, 2)))
    tracks.confirmed[:] = False
    angle = rng.uniform(0, np.pi, 5)
    axis = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    spread = 400 * axis[:, :, None] * axis[:, None] + rng.uniform(4, 100, (5, 1, 1)) * np.eye(2)
    predicted = replace(tracks.prediction(), spread=spread)
    gap = blobs.foot - predicted.foot[:, None]
    cost = np.einsum('tbi,tij,tbj->tb', gap, np.linalg.inv(spread), gap)
    cost += np.log(np.linalg.det(spread))[:, None]
    cost += SIZE_WEIGHT * np.log2(blobs.box[:, 3] / predicted.box[:, 3:]) ** 2
    ways = np.array(list(permutations(range(5), 3)))
    likeliest = ways[cost[ways, np.arange(3)].sum(axis=1).argmin()]
    blob_of = match(tracks, predicted, blobs, np.zeros((3, 48)), config)
    assert [np.flatnonzero(blob_of == blob).tolist() for blob in range(3)] == [
        [track] for track in likeliest
    ]


def test_order_of_blobs_does_not_matter(scene):
    places = [(0, 0), (2, 1), (-3, 2)]
    blobs = scene.boxes(np.array(places) + 0.1)
    order = np.array([2, 0, 1])
    assert order[scene(places, blobs[order])].tolist() == scene(places, blobs).tolist()


@pytest.mark.parametrize(('tracks', 'blobs'), [(0, 0), (0, 2), (2, 0)])
def test_nothing_to_match_is_no_error(scene, tracks, blobs):
    places = [(0.0, 0.0), (3.0, 1.0)]
    blob_of = scene(places[:tracks], scene.boxes(places[:2])[:blobs])
    assert blob_of.tolist() == [-1] * tracks
