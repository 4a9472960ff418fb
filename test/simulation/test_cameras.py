import numpy as np
import pytest

from mctrack_ros.simulation import LENGTH_M, WIDTH_M, Scenario, landmarks, pitch5_cameras

PITCH = np.stack(np.meshgrid(np.arange(0, 105.1, 1.5), np.arange(0, 68.1, 1.7)), -1).reshape(-1, 2)
PITCH = np.column_stack([PITCH, np.zeros(len(PITCH))])
HEADS = PITCH + np.array([0, 0, 1.8])


@pytest.mark.parametrize('distortion', [0.0, -0.2, 0.3])
def test_ground_inverts_project(distortion):
    for camera in pitch5_cameras(Scenario(distortion=distortion)):
        seen = PITCH[camera.sees(PITCH)]
        np.testing.assert_allclose(camera.ground(camera.project(seen)), seen[:, :2], atol=1e-6)


def test_the_sky_is_nowhere_on_the_ground():
    camera = pitch5_cameras(Scenario())[0]
    assert np.isnan(camera.ground([[384.0, -3000.0]])).all()


def test_whole_pitch_is_covered_and_most_of_it_twice():
    count = sum(camera.sees(PITCH).astype(int) for camera in pitch5_cameras(Scenario()))
    assert count.min() >= 1
    assert (count >= 2).mean() > 0.9


def test_penalty_areas_are_seen_from_nearly_orthogonal_sides():
    for name in ('penalty_spot_west', 'penalty_spot_east'):
        spot = np.array([*landmarks()[name], 0.0])
        towards = [c.position - spot for c in pitch5_cameras(Scenario()) if c.sees(spot)]
        directions = [d[:2] / np.linalg.norm(d[:2]) for d in towards]
        angles = [
            np.degrees(np.arccos(a @ b)) for a in directions for b in directions if a is not b
        ]
        assert min(abs(angle - 90) for angle in angles) < 25


def test_people_are_tall_enough_in_the_best_image():
    tall = []
    for camera in pitch5_cameras(Scenario()):
        rows = camera.project(PITCH)[:, 1] - camera.project(HEADS)[:, 1]
        tall.append(np.where(camera.sees(PITCH), rows, 0))
    best = np.max(tall, axis=0)
    assert best.min() > 20
    assert np.median(best) > 30


def test_landmarks_lie_on_the_pitch():
    points = np.array(list(landmarks().values()))
    assert len(np.unique(points, axis=0)) == len(points) == 17
    assert (points >= 0).all()
    assert (points <= [LENGTH_M, WIDTH_M]).all()
