import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode, EventCode
from mctrack_ros.perception import CAMERA, BackwardStampError, Given, open_camera
from mctrack_ros.perception.silhouettes import SilhouetteConfig, SilhouettePipeline, as_printed

SIZE = (640, 480)
PERIOD_NS = 250_000_000
PERSON, CAR = (20, 62), (150, 70)
OURS = SilhouetteConfig()
VERSIONS = pytest.mark.parametrize('config', [OURS, as_printed()], ids=['ours', 'printed'])


@VERSIONS
def test_a_pedestrian_keeps_one_id_and_is_passed_on_after_three_seconds(new_park, config):
    park, ids, passed, stable = new_park(config), set(), [], []
    for step in range(20):
        output = park.show([(100 + 6 * step, 380, PERSON, 60)])
        ids |= set(output.detections.local_id.tolist())
        passed.append(park.pipeline.objects.passed_on.any())
        stable.append(int((output.events.event == EventCode.STABLE).sum()))
    assert len(ids) == 1
    assert passed.index(True) == stable.index(1) == 12
    assert sum(stable) == 1
    assert output.detections.class_id.tolist() == [ClassCode.PERSON]


@VERSIONS
def test_a_vehicle_is_known_as_one_and_never_passed_on(new_park, config):
    park = new_park(config)
    for step in range(20):
        output = park.show([(100 + 15 * step, 300, CAR, 160)])
    assert output.detections.class_id.tolist() == [ClassCode.VEHICLE]
    assert not park.pipeline.objects.passed_on.any()


def test_detections_stand_where_the_feet_are_with_a_sound_covariance(new_park, mapping):
    park = new_park(OURS)
    for step in range(12):
        x = 200 + 8 * step
        output = park.show([(x, 380, PERSON, 60)])
    expected = mapping.ground_from_image([[x, 380]])[0]
    assert np.allclose(output.detections.position[0, :2], expected, atol=0.25)
    assert (np.linalg.eigvalsh(output.detections.covariance[0]) > 0).all()
    assert output.detections.template[0].sum() == pytest.approx(1.0, abs=1e-4)


def test_two_who_pass_keep_their_ids_and_tell_of_a_merge_and_a_split(new_park):
    park, events, first = new_park(OURS), [], None
    for step in range(44):
        x = 180 + 6 * step
        output = park.show([(x, 380, PERSON, 60), (620 - x, 388, (22, 60), 170)])
        events += output.events.event.tolist()
        first = output.detections if step == 12 else first
    last = output.detections
    assert first.local_id[np.argsort(first.box[:, 0])].tolist() == (
        last.local_id[np.argsort(-last.box[:, 0])].tolist()
    )
    assert events.count(EventCode.NEW) == 2


def test_who_leaves_the_image_is_an_exit_and_ids_are_never_used_again(new_park):
    park, events, ids = new_park(OURS), [], []
    for _ in range(2):
        for step in range(40):
            output = park.show([(500 + 8 * step, 380, PERSON, 60)] if step < 20 else [])
            events += output.events.event.tolist()
            ids += output.detections.local_id.tolist()
    assert events.count(EventCode.NEW) == events.count(EventCode.EXIT) == 2
    assert len(set(ids)) == 2


def test_who_comes_in_where_somebody_has_just_left_is_another(new_park):
    park, before, after = new_park(OURS), set(), set()
    for step in range(24):
        output = park.show([(500 + 8 * step, 380, PERSON, 60)])
        before |= set(output.detections.local_id.tolist())
    for step in range(16):
        output = park.show([(650 - 8 * step, 380, PERSON, 170)])
        after |= set(output.detections.local_id.tolist())
    assert len(before) == len(after) == 1
    assert before.isdisjoint(after)


@VERSIONS
def test_a_parked_vehicle_becomes_background_after_four_seconds(new_park, config):
    park = new_park(config)
    for step in range(14):
        park.show([(80 + 15 * step, 300, CAR, 160)])
    shown = [len(park.show([(275, 300, CAR, 160)]).detections) for _ in range(24)]
    assert shown[10] == 1
    assert shown[-1] == 0
    assert not len(park.show([(275, 300, CAR, 160)]).events)


@VERSIONS
def test_a_pedestrian_is_tracked_before_a_parked_vehicle(new_park, config):
    park, car = new_park(config), (275, 300, CAR, 160)
    for step in range(40):
        park.show([(min(80 + 15 * step, 275), 300, CAR, 160)])
    for step in range(14):
        output = park.show([car, (230 + 6 * step, 310, PERSON, 60)])
    assert output.detections.class_id.tolist() == [ClassCode.PERSON]
    assert output.detections.box[0, 2] < 40


@pytest.mark.parametrize('learned', [True, False], ids=['parked', 'there at first'])
def test_a_vehicle_that_drives_off_leaves_no_hole(new_park, mapping, learned):
    park = new_park(OURS)
    if learned:
        for step in range(40):
            park.show([(min(80 + 15 * step, 275), 300, CAR, 160)])
    else:
        background = park.image([(275, 300, CAR, 160)])
        park.pipeline = SilhouettePipeline(OURS, mapping, background=background)
        for _ in range(4):
            park.show([(275, 300, CAR, 160)])
    for step in range(14):
        output = park.show([(275 + 18 * step, 300, CAR, 160)])
    assert len(output.detections) == 1
    assert output.detections.box[0, 0] > 400


def test_a_change_of_most_of_the_image_restarts_tracking(new_park):
    park = new_park(OURS)
    for step in range(12):
        park.show([(100 + 8 * step, 380, PERSON, 60)])
    y, x = np.indices(park.ground.shape) // 40
    park.ground = np.where((x + y) % 2, 30.0, 220.0)
    assert not len(park.show([(200, 380, PERSON, 60)]).detections)
    assert not len(park.pipeline.objects.local_id)


@VERSIONS
@pytest.mark.parametrize('kind', ['black', 'white', 'frozen', 'noise'])
def test_images_that_show_nothing_give_one_detection_each_at_most(new_park, config, kind):
    park, rng = new_park(config), np.random.default_rng(4)
    for step in range(12):
        park.show([(100 + 8 * step, 380, PERSON, 60)])
    still, found = park.image([(200, 380, PERSON, 60)]), 0
    for _ in range(12):
        image = {
            'black': np.zeros_like(still),
            'white': np.full_like(still, 255),
            'frozen': still,
            'noise': rng.integers(0, 256, still.shape).astype(np.uint8),
        }[kind]
        found += len(park.step(image).detections)
    assert found <= (12 if kind in ('frozen', 'noise') else 0)
    for step in range(24):
        output = park.show([(100 + 8 * step, 380, PERSON, 60)])
    assert len(output.detections) == 1


@pytest.mark.parametrize(
    ('image', 'reason'),
    [
        (np.zeros((240, 320, 3), np.uint8), 'image is 320 x 240, expected 640 x 480'),
        (np.zeros((480, 640), np.uint8), r'image has shape \(480, 640\)'),
        (np.zeros((480, 640, 3), np.float32), 'and type float32, expected'),
    ],
    ids=['size', 'grey', 'type'],
)
def test_an_image_of_another_size_or_type_is_refused(mapping, image, reason):
    with pytest.raises(ValueError, match=reason):
        SilhouettePipeline(OURS, mapping).step(image, 1, None)


def test_a_stamp_that_comes_again_is_refused_and_changes_nothing(new_park):
    park = new_park(OURS)
    with pytest.raises(BackwardStampError):
        park.pipeline.step(park.image([]), park.index * PERIOD_NS, None)
    park.show([])


def test_a_gap_restarts_tracks_but_not_ids(new_park):
    park = new_park(OURS)
    for step in range(12):
        first = park.show([(100 + 8 * step, 380, PERSON, 60)])
    park.index += 40
    for step in range(12):
        second = park.show([(100 + 8 * step, 380, PERSON, 60)])
    assert second.detections.local_id[0] > first.detections.local_id[0]


def test_what_the_mask_hides_is_ignored(new_park, mapping):
    park = new_park(OURS)
    ignored = np.zeros(SIZE[::-1], np.uint8)
    park.pipeline = SilhouettePipeline(OURS, mapping, ignored, park.image([]))
    for step in range(8):
        output = park.show([(100 + 8 * step, 380, PERSON, 60)])
    assert not len(output.detections)


def test_the_same_images_give_the_same_output(new_park):
    def run():
        park = new_park(OURS)
        return [
            park.show([(180 + 6 * k, 380, PERSON, 60), (460 - 6 * k, 385, PERSON, 170)])
            for k in range(40)
        ]

    for one, other in zip(run(), run()):
        for name in one.detections.COLUMNS:
            mine, theirs = getattr(one.detections, name), getattr(other.detections, name)
            assert np.array_equal(mine, theirs)


def test_tracking_works_at_25_images_a_second(mapping, new_park):
    park, ids = new_park(OURS), set()
    for step in range(100):
        park.index += 1
        stamp_ns = PERIOD_NS + park.index * 40_000_000
        image = park.image([(100 + step, 380, PERSON, 60)])
        ids |= set(park.pipeline.step(image, stamp_ns, None).detections.local_id.tolist())
    assert len(ids) == 1
    assert park.pipeline.objects.passed_on.all()


def test_the_site_chooses_the_tracker(mapping):
    config = CAMERA.made('silhouettes')
    assert isinstance(open_camera(config, Given('cam1', mapping)), SilhouettePipeline)
