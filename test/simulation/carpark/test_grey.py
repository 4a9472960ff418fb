import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import GREY_CARPARK, GreyCarParkScenario
from mctrack_ros.simulation.calibration import write_calibration
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import load_site


@pytest.fixture(scope='module', params=[1, 2, 3, 3003])
def world(request):
    """Seed 3003 finds no room at its first attempt."""
    return GREY_CARPARK.world(GreyCarParkScenario(seed=request.param))


def test_six_people_walk_among_three_cars(world):
    person = world.class_id == ClassCode.PERSON
    assert (person.sum(), (~person).sum()) == (6, 3)
    assert world.active.any(axis=0).all()
    assert world.parked[:, ~person].any(axis=0).sum() == 2
    assert np.isfinite(world.motion.position[world.present]).all()


def test_nobody_is_run_over(world):
    place, there = world.motion.position, world.present
    person = np.flatnonzero(world.class_id == ClassCode.PERSON)
    for car in np.flatnonzero(world.class_id == ClassCode.VEHICLE):
        moves = np.linalg.norm(world.motion.velocity[:, car], axis=1) > 0.5
        together = there[:, person] & (there[:, car] & moves)[:, None]
        gap = np.linalg.norm(place[:, person] - place[:, [car]], axis=2)
        assert gap[together].min(initial=9.0) > 1.0


def test_most_are_seen_by_several_cameras(world):
    inside = world.feet_in_view.any(axis=1)
    assert world.feet_in_view.sum(axis=1)[inside].mean() > 2.5


def test_every_camera_renders_and_meters_what_it_sees():
    scenario = GreyCarParkScenario(seed=1)
    world = GREY_CARPARK.world(scenario)
    for camera in range(4):
        image, view = GREY_CARPARK.renderer(world, camera).frame(260)
        assert image.shape == (480, 640)
        assert len(view.person) >= 6


def test_shipped_files_are_what_the_code_gives(tmp_path):
    write_calibration(GreyCarParkScenario(), tmp_path)
    shipped = config_file('grey_carpark.yaml').parent / 'grey_carpark'
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == ['cam1.xml', 'cam2.xml', 'cam3.xml', 'cam4.xml', 'scene.xml']
    for name in names:
        assert (shipped / name).read_text() == (tmp_path / name).read_text(), name


def test_its_site_gets_the_tracker_of_vehicles_and_says_why():
    site, why = with_tracker(load_site(config_file('grey_carpark.yaml')))
    assert site.fusion.tracker == 'vehicles'
    assert 'vehicles' in why


@pytest.mark.parametrize(
    ('wrong', 'said'), [({'cameras': 5}, '1 to 4'), ({'duration_s': 9.0}, '24')]
)
def test_what_cannot_be_simulated_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        GreyCarParkScenario(**wrong)
