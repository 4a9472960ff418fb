import json

import pytest

from mctrack_ros.codec import image_from_message
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.simulation import CarParkScenario, Scenario
from mctrack_ros.simulation.recording import simulate

SCENARIO = Scenario(seed=5, duration_s=1.2, width=192, height=144)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp('bags') / 'match'
    simulate(SCENARIO, path, processes=2)
    return path


def contents(folder):
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


def test_bytes_do_not_depend_on_the_number_of_processes(bag, rendering_here, tmp_path):
    again = tmp_path / bag.name
    simulate(SCENARIO, again)
    assert contents(again) == contents(bag)


def test_bag_holds_images_and_truth_in_the_middle_of_their_periods(bag):
    with BagReader(bag) as reader:
        messages = list(reader.messages())
    stamps = [time for topic, _, time in messages if topic == '/cam3/image_raw/compressed']
    assert stamps == [SCENARIO.stamp_ns(step) for step in range(SCENARIO.steps)]
    assert [time for *_, time in messages] == sorted(time for *_, time in messages)
    first = next(message for topic, message, _ in messages if topic.endswith('compressed'))
    assert image_from_message(first).shape == (144, 192, 3)
    topics = {topic for topic, *_ in messages}
    assert {'/site', '/truth/tracks', '/truth/cam1/detections', '/truth/cam1/events'} <= topics


def test_a_run_that_breaks_off_leaves_no_bag(rendering_here, tmp_path):
    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(SCENARIO, tmp_path / 'match', progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_a_bag_already_there_is_kept_unless_told_otherwise(bag):
    with pytest.raises(BagError, match=r'exists already.* by --overwrite'):
        simulate(SCENARIO, bag)


def test_the_car_park_says_what_it_is_and_who_is_parked(rendering_here, tmp_path):
    simulate(CarParkScenario(duration_s=1.0), tmp_path / 'park')
    with BagReader(tmp_path / 'park') as reader:
        messages = list(reader.messages())
    by_topic = {topic: message for topic, message, _ in messages}
    image = image_from_message(by_topic['/cam1/image_raw/compressed'])
    assert image.shape == (480, 640, 3)
    assert (image == image[..., :1]).all()
    assert json.loads(by_topic['/site'].data)['scene'] == 'carpark'
    assert by_topic['/truth/parked'].width > by_topic['/truth/cam1/parked'].width > 5
    assert by_topic['/truth/tracks'].width == 0
