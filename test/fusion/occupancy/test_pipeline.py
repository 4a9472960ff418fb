"""The tracker of the people who explain all masks."""

import numpy as np
import pytest

from masks import AREA, MAPPINGS, SHAPE, foreground_of
from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import open_fusion
from mctrack_ros.fusion.inputs import OccupancyInput
from mctrack_ros.fusion.occupancy.config import OccupancyConfig, PeopleConfig, VehicleConfig
from mctrack_ros.fusion.occupancy.masks import Unusable
from mctrack_ros.fusion.views import Views
from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.interfaces import CameraRows, Detections, Foreground, RowsTick

PERIOD_NS = 40_000_000
NAMES = tuple(MAPPINGS)
PLACES = np.array([[0.3, 0.2], [-1.2, 0.9]])


def views():
    return Views(MAPPINGS, area_from(AREA))


class Watch:
    """Drives a tracker with masks; some cameras may tell something else, or nothing (None)."""

    def __init__(self, **people):
        config = OccupancyConfig(people=PeopleConfig(**people))
        self.tracker = open_fusion(config, NAMES, views=views)
        self.stamp_ns = 10**12

    def see(self, people=PLACES, detections=None, **others):
        messages = []
        for name in NAMES:
            told = others.get(name, foreground_of(name, people, self.stamp_ns))
            if told is not None:
                own = (detections or Detections.build(0)).at(self.stamp_ns)
                messages.append(CameraRows(name, OccupancyInput(own, told)))
        output = self.tracker.step(RowsTick.of(messages))
        self.stamp_ns += PERIOD_NS
        return output

    def watch(self, count=25, people=PLACES, **others):
        for _ in range(count):
            output = self.see(people, **others)
        return output


def check_found(output, people=PLACES):
    gaps = np.linalg.norm(output.tracks.position[:, None, :2] - people, axis=2)
    assert gaps.shape == (len(people), len(people))
    assert gaps.min(axis=0).max() < 0.3


def all_white(stamp_ns):
    return Foreground(stamp_ns, np.full(SHAPE, 255, np.uint8))


@pytest.mark.parametrize('config', [OccupancyConfig, VehicleConfig])
def test_untrusted_cameras_are_refused_with_the_remedy(config):
    with pytest.raises(ConfigError, match=r'^untrusted is .* name joint$'):
        open_fusion(config(untrusted=NAMES[0]), NAMES, views=views)


def test_people_are_tracked_by_their_masks_alone():
    watch = Watch()
    output = watch.watch()
    check_found(output)
    assert output.left_out == {}
    assert len(watch.tracker.feedback()) == 2
    assert watch.tracker.next_id == 3


def test_tracks_carry_the_bits_of_the_cameras_that_see_them():
    assert Watch().watch().tracks.cameras.tolist() == [0b111, 0b111]
    watch = Watch()
    watch.watch(5)
    bits = watch.watch(20, south=None).tracks.cameras
    assert bits.tolist() == [0b011, 0b011]
    assert watch.watch(1, people=np.zeros((0, 2))).tracks.cameras.tolist() == [0, 0]


@pytest.mark.parametrize('spoiled', NAMES)
def test_a_dazzled_camera_is_left_out(spoiled):
    watch = Watch()
    for _ in range(25):
        output = watch.see(**{spoiled: all_white(watch.stamp_ns)})
    check_found(output)
    assert output.left_out == {spoiled: Unusable.DAZZLED}


def test_a_camera_that_knows_no_background_is_left_out():
    watch = Watch()
    for _ in range(25):
        output = watch.see(east=Foreground.build(watch.stamp_ns))
    check_found(output)
    assert output.left_out == {'east': Unusable.UNKNOWN}


def test_a_frozen_camera_is_left_out_until_its_mask_changes():
    watch, walked = Watch(), np.linspace(-1.0, 1.0, 150)
    frozen = foreground_of('east', [[1.0, -1.5]], 0)
    for x in walked:
        output = watch.see(np.array([[x, 1.0]]), east=frozen.at(watch.stamp_ns))
    assert output.left_out == {'east': Unusable.FROZEN}
    check_found(output, np.array([[1.0, 1.0]]))
    assert watch.see(np.array([[1.0, 1.0]])).left_out == {}


def test_a_camera_that_shows_nobody_for_long_is_not_frozen():
    watch, nobody = Watch(), np.zeros((0, 2))
    assert watch.watch(150, people=nobody).left_out == {}


def test_a_mask_counts_a_little_longer_than_its_tick_then_its_camera_is_silent():
    watch = Watch()
    watch.watch(10)
    said = [watch.see(south=None).left_out for _ in range(10)]
    assert said[:7] == 7 * [{}]
    assert said[7:] == 3 * [{'south': Unusable.SILENT}]


def test_without_any_usable_camera_nobody_is_found_and_fusion_goes_on():
    watch = Watch()
    for _ in range(10):
        white = {name: all_white(watch.stamp_ns) for name in NAMES}
        output = watch.see(**white)
    assert len(output.tracks) == 0
    assert set(output.left_out) == set(NAMES)
    check_found(watch.watch())


def test_the_same_masks_give_the_same_bytes():
    def tracks():
        watch, rng = Watch(), np.random.default_rng(3)
        for step in range(30):
            people = PLACES + 0.03 * step + rng.normal(0, 0.02, PLACES.shape)
            yield watch.see(people).tracks

    for one, other in zip(tracks(), tracks(), strict=True):
        for name in one.COLUMNS:
            assert getattr(one, name).tobytes() == getattr(other, name).tobytes()


def test_time_that_steps_back_begins_anew():
    watch, fresh = Watch(), Watch()
    watch.watch(25, people=np.array([[1.0, -1.0]]))
    watch.stamp_ns = fresh.stamp_ns = 10**11
    output = watch.see(south=None)
    assert output.left_out == {'south': Unusable.SILENT}
    fresh.see(south=None)
    for _ in range(20):
        one, other = watch.see(), fresh.see()
        np.testing.assert_array_equal(one.tracks.position, other.tracks.position)
    check_found(one)
    assert one.tracks.track_id.min() > 1


def test_a_person_who_is_certain_to_the_cell_is_tracked_too():
    people = np.array([[0.0, 0.0], [-1.0, 1.0]])
    output = Watch(cell=1.0).watch(people=people)
    check_found(output, people)
    assert (np.linalg.eigvalsh(output.tracks.covariance[:, :2, :2]) > 0).all()


def test_colours_and_sizes_are_those_of_the_cameras_own_detections():
    watch = Watch()
    size = Detections.COLUMNS['template'].shape
    template = np.zeros((3, *size), np.float32)
    template[0, 0], template[1, 5] = 1.0, 1.0
    columns = {
        'position': [[0.4, 0.2, 0], [-1.1, 1.0, 0], [2.5, -2.5, 0]],
        'template': template,
        'extent': [[0.5, 1.7], [0.6, 1.9], [9.0, 9.0]],
    }
    output = watch.watch(40, detections=Detections.build(watch.stamp_ns, **columns))
    told = watch.tracker.feedback()
    nearest = np.linalg.norm(told.position[:, None, :2] - PLACES, axis=2).argmin(axis=0)
    assert told.template[nearest].argmax(axis=1).tolist() == [0, 5]
    np.testing.assert_allclose(told.extent[nearest, 1], [1.7, 1.9], atol=0.05)
    check_found(output)


def test_a_camera_that_is_not_of_the_site_is_refused():
    watch = Watch()
    rows = OccupancyInput(Detections.build(1), Foreground.build(1))
    with pytest.raises(ValueError, match="camera is 'west', expected one of"):
        watch.tracker.step(RowsTick.of([CameraRows('west', rows)]))


def test_without_calibrations_it_is_refused():
    with pytest.raises(ConfigError, match='name the site'):
        open_fusion(OccupancyConfig(), NAMES)
