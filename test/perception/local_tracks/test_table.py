import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import FilterConfig, LocalTracks

STEP_S = 0.04


@pytest.fixture
def tracks(mapping):
    return LocalTracks(FilterConfig(), mapping, SizeTable(mapping))


def begin(tracks, mapping, position):
    foot = mapping.image_from_ground(position)
    box = SizeTable(mapping).box_of(foot, np.tile([0.6, 1.75], (len(foot), 1)))
    noise = tracks.foot_noise(box)
    return tracks.start(np.asarray(position, float), box, noise, np.zeros((len(foot), 48)), 0)


def test_filter_learns_the_velocity_of_a_walker(tracks, mapping):
    rng = np.random.default_rng(0)
    place, velocity = np.array([[-3.0, 1.0]]), np.array([[1.2, -0.4]])
    rows = begin(tracks, mapping, place)
    noise = np.eye(2)[None] * 1.5**2
    for _ in range(100):
        place = place + velocity * STEP_S
        tracks.predict(STEP_S)
        foot = mapping.image_from_ground(place) + rng.normal(0, 1.5, (1, 2))
        tracks.update(tracks.prediction(), rows, foot, noise)
    assert np.allclose(tracks.mean[0, :2], place[0], atol=0.25)
    assert np.allclose(tracks.mean[0, 2:], velocity[0], atol=0.6)


def test_update_is_that_of_the_textbook_one_track_at_a_time(tracks, mapping):
    places = np.array([[0.0, 0.0], [3.0, 2.0], [-2.0, 4.0]])
    begin(tracks, mapping, places)
    tracks.predict(0.2)
    error = np.array([[1.0, -2.0], [0.5, 0.5], [-3.0, 1.0]])
    foot = mapping.image_from_ground(tracks.mean[:, :2]) + error
    noise = np.tile(np.diag([2.0, 3.0]), (3, 1, 1))
    expected = []
    for mean, covariance, measured, own in zip(tracks.mean, tracks.covariance, foot, noise):
        jacobian = np.zeros((2, 4))
        jacobian[:, :2] = mapping.image_jacobian(mean[None, :2])[0]
        innovation = measured - mapping.image_from_ground(mean[None, :2])[0]
        gain = covariance @ jacobian.T @ np.linalg.inv(jacobian @ covariance @ jacobian.T + own)
        expected.append((mean + gain @ innovation, covariance - gain @ jacobian @ covariance))
    tracks.update(tracks.prediction(), np.arange(3), foot, noise)
    assert np.allclose(tracks.mean, [mean for mean, _ in expected])
    assert np.allclose(tracks.covariance, [covariance for _, covariance in expected])


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 2.0), min_size=1, max_size=12), st.floats(-8.0, 8.0))
@example([0.125, 2.0, 0.125, 1.0, 1.0, 0.0], 4.0).via('was predicted behind the camera')
def test_covariances_stay_positive_definite(mapping, waits, error):
    tracks = LocalTracks(FilterConfig(), mapping, SizeTable(mapping))
    rows = begin(tracks, mapping, np.array([[0.0, 0.0]]))
    for seconds in waits:
        tracks.predict(seconds)
        foot = mapping.image_from_ground([[0.0, 0.0]]) + error
        tracks.update(tracks.prediction(), rows, foot, np.eye(2)[None])
        assert np.linalg.eigvalsh(tracks.covariance[0]).min() > 0


def stand_with(tracks, mapping, spread_px):
    """Let two stand whose feet are seen with the noise that is believed, and with another."""
    rng, places = np.random.default_rng(5), np.array([[-1.0, 1.0], [2.0, 1.0]])
    rows = begin(tracks, mapping, places)
    ratios = []
    for _ in range(500):
        tracks.predict(STEP_S)
        predicted = tracks.prediction()
        noise = tracks.foot_noise(predicted.box)
        deviation = np.sqrt(noise[:, [0, 1], [0, 1]])
        deviation[1] = spread_px
        foot = mapping.image_from_ground(places) + rng.normal(0.0, deviation)
        noise[:, [0, 1], [0, 1]] *= tracks.noise_ratio
        tracks.follow_noise(predicted, rows, foot, noise, STEP_S)
        tracks.update(predicted, rows, foot, noise)
        ratios.append(tracks.noise_ratio)
    return np.mean(ratios[250:], axis=0), noise[:, [0, 1], [0, 1]] / tracks.noise_ratio


def test_noise_becomes_what_is_observed_along_each_axis(tracks, mapping):
    ratio, believed = stand_with(tracks, mapping, [12.0, 8.0])
    assert np.allclose(ratio[1] * believed[1], [144.0, 64.0], rtol=0.3)
    assert np.allclose(ratio[0], 1.0, atol=0.35)


def test_steady_feet_are_believed_no_more_than_all(tracks, mapping):
    ratio, _ = stand_with(tracks, mapping, [0.1, 0.1])
    assert np.allclose(ratio[1], 1.0)


def test_one_leap_does_not_ruin_the_noise(tracks, mapping):
    rows = begin(tracks, mapping, np.array([[0.0, 1.0]]))
    tracks.predict(STEP_S)
    predicted = tracks.prediction()
    noise = tracks.foot_noise(predicted.box)
    tracks.follow_noise(predicted, rows, predicted.foot + 1e4, noise, STEP_S)
    assert (tracks.noise_ratio < 10.0).all()
    tracks.follow_noise(predicted, rows, np.full((1, 2), np.nan), noise, STEP_S)
    assert np.isfinite(tracks.noise_ratio).all()


def test_fixed_noise_stays(mapping):
    tracks = LocalTracks(FilterConfig(noise_time_s=0.0), mapping, SizeTable(mapping))
    stand_with(tracks, mapping, [12.0, 8.0])
    assert np.array_equal(tracks.noise_ratio, np.ones((2, 2)))


def test_ids_are_not_used_twice(tracks, mapping):
    begin(tracks, mapping, np.zeros((3, 2)))
    tracks.keep(np.zeros(3, bool))
    begin(tracks, mapping, np.zeros((2, 2)))
    tracks.clear()
    begin(tracks, mapping, np.zeros((1, 2)))
    assert tracks.local_id.tolist() == [6]


def test_prediction_stands_on_the_predicted_place(tracks, mapping):
    begin(tracks, mapping, np.array([[2.0, 1.0]]))
    predicted = tracks.prediction()
    assert np.allclose(predicted.foot, mapping.image_from_ground([[2.0, 1.0]]))
    assert np.allclose(predicted.box[0, 1] + predicted.box[0, 3], predicted.foot[0, 1])
    assert np.linalg.eigvalsh(predicted.spread).min() > 0
