import cv2
import numpy as np
import pytest

from mctrack_ros.recording import BagReader
from mctrack_ros.simulation import PTZ, PtzScenario, landmarks
from mctrack_ros.simulation.recording import simulate

SHORT = PtzScenario(seed=4, duration_s=0.2)
PLACES = np.array([(*place, 0.0) for place in landmarks().values()])


def test_cameras_pan_tilt_and_zoom_about_a_fixed_place():
    for camera in PTZ.cameras(PtzScenario(seed=4, duration_s=60)):
        forward = np.array([each.rotation[2] for each in camera.steps])
        turns = np.degrees(np.arccos(np.clip(forward @ forward[0], -1, 1)))
        focal = np.array([each.focal_px for each in camera.steps])
        assert turns.max() > 15
        assert np.abs(np.diff(turns)).max() < 1
        assert focal.max() / focal.min() > 1.1
        assert len({tuple(each.position) for each in camera.steps}) == 1


def test_paths_follow_the_seed_or_the_play():
    def first(**options):
        return PTZ.cameras(PtzScenario(duration_s=1, **options))[0].at(0).rotation

    np.testing.assert_array_equal(first(seed=4), first(seed=4))
    assert not np.allclose(first(seed=4), first(seed=5))
    assert not np.allclose(first(seed=4), first(seed=4, follows_play=True))


def test_images_show_the_lines_where_the_calibration_says():
    world = PTZ.world(PtzScenario(seed=4, duration_s=12))
    halfway = np.array([(52.5, y, 0.0) for y in np.linspace(2, 66, 300)])
    for step in (0, 150, 290):
        image = PTZ.renderer(world, 0).frame(step)[0].max(axis=2)
        camera = world.views(step)[0]
        line = halfway[camera.sees(halfway)]
        beside = line + np.array([0.9, 0, 0])
        on, off = (
            np.median(image[tuple(np.floor(camera.project(each)).astype(int).T[::-1])])
            for each in (line, beside[camera.sees(beside)])
        )
        assert on > off + 30


def test_people_stand_where_the_truth_says():
    world = PTZ.world(SHORT)
    view = PTZ.renderer(world, 1).frame(2)[1]
    camera = world.views(2)[1]
    whole = ~view.truncated & world.feet_in_view[2, 1, view.person]
    feet = view.box[whole, :2] + view.box[whole, 2:] * [0.5, 1]
    missed = camera.ground(feet) - world.motion.position[2, view.person[whole]]
    assert np.median(np.linalg.norm(missed, axis=1)) < 0.5


def test_a_warp_takes_one_view_to_another():
    one, other = PTZ.cameras(SHORT)[0].at(0), PTZ.cameras(PtzScenario(seed=9))[0].at(0)
    place = PLACES[one.sees(PLACES)]
    warped = cv2.perspectiveTransform(one.project(place)[None] - 0.5, other.warp_from(one))[0]
    np.testing.assert_allclose(warped + 0.5, other.project(place), atol=1e-6)


def test_the_bag_holds_the_calibration_of_every_image(tmp_path):
    simulate(SHORT, tmp_path / 'bag', processes=1)
    with BagReader(tmp_path / 'bag') as bag:
        topics = bag.topics
    assert {'/truth/cam1/calibration', '/truth/cam2/calibration'} <= set(topics)


@pytest.mark.parametrize('options', [{'cameras': 3}, {'distortion': 0.1}])
def test_what_cannot_be_is_refused(options):
    with pytest.raises(ValueError, match='expected'):
        PtzScenario(**options)
