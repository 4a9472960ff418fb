import numpy as np
import pytest

from mctrack_ros.perception.blobs import BlobConfig, describe
from mctrack_ros.perception.local_tracks import FilterConfig, LocalTracks
from mctrack_ros.perception.matching import MatchingConfig, match
from mctrack_ros.perception.sizes import SizeTable

RED, BLUE = np.eye(48)[0], np.eye(48)[20]


@pytest.fixture
def scene(mapping):
    """Match confirmed tracks at some places to blobs at others, with their colours."""
    sizes = SizeTable(mapping)

    def boxes(places):
        foot = mapping.image_from_ground(places)
        return sizes.box_of(foot, np.tile([0.6, 1.75], (len(foot), 1)))

    def matched(tracks_at, blobs, colours=None, template=None):
        tracks = LocalTracks(FilterConfig(), mapping, sizes)
        box = boxes(tracks_at)
        known = np.zeros((len(box), 48)) if template is None else np.array(template)
        places = np.array(tracks_at, float).reshape(-1, 2)
        tracks.start(places, box, tracks.foot_noise(box), known, 0)
        tracks.confirmed[:] = True
        found, _ = describe(blobs, np.prod(blobs[:, 2:], axis=1), mapping, sizes, BlobConfig())
        seen = np.zeros((len(blobs), 48)) if colours is None else np.array(colours)
        return match(tracks, tracks.prediction(), found, seen, MatchingConfig())

    matched.boxes = boxes
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
