import shutil

import numpy as np
import pytest
import yaml
from hypothesis import given, settings

from mctrack_ros.codec import cloud_from_rows, image_message, rows_from_cloud
from mctrack_ros.interfaces import Detections, Events, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES, BagError, BagReader, BagWriter
from strategies import rows


@pytest.fixture
def bag(tmp_path):
    """Return a bag of 200 detections' messages and one text."""
    rng = np.random.default_rng(1)
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_text('/site', '{}', 0)
        for index in range(200):
            detections = Detections.build(
                index, position=rng.normal(size=(5, 3)), local_id=[1, 2, 3, 4, index]
            )
            writer.write_rows('/cam1/detections', detections, 'map')
    return tmp_path / 'bag'


def test_what_was_written_is_read_in_order(bag):
    with BagReader(bag) as reader:
        assert reader.topics == {
            '/site': 'std_msgs/msg/String',
            '/cam1/detections': 'sensor_msgs/msg/PointCloud2',
        }
        assert reader.count('/cam1/detections') == 200
        stamps = [
            rows_from_cloud(message, Detections).stamp_ns
            for _, message, _ in reader.messages(['/cam1/detections'])
        ]
    assert stamps == list(range(200))


@settings(max_examples=20, deadline=None)
@given(given_rows=rows())
def test_rows_survive_a_bag(tmp_path_factory, given_rows):
    path = tmp_path_factory.mktemp('bags') / 'bag'
    with BagWriter(path) as writer:
        writer.write_rows('/rows', given_rows, 'map')
    with BagReader(path) as reader:
        ((_, message, time_ns),) = reader.messages()
    assert time_ns == given_rows.stamp_ns
    back = rows_from_cloud(message, type(given_rows))
    for name in given_rows.COLUMNS:
        assert getattr(back, name).tobytes() == getattr(given_rows, name).tobytes(), name


def test_the_same_messages_give_the_same_bytes(bag, tmp_path):
    with BagReader(bag) as reader, BagWriter(tmp_path / 'again' / 'bag') as writer:
        for item in reader.serialized():
            writer.write_copy(reader, *item)
    first, second = (
        sorted(p.read_bytes() for p in path.iterdir()) for path in (bag, tmp_path / 'again/bag')
    )
    assert first == second


def test_part_of_a_bag_is_read_by_log_time(bag):
    with BagReader(bag) as reader:
        times = [time for _, _, time in reader.messages(['/cam1/detections'], 50, 53)]
    assert times == [50, 51, 52]


def test_clouds_are_read_as_rows(bag):
    with BagReader(bag) as reader:
        read = list(reader.rows('/cam1/detections', Detections, 10, 12))
    assert [(rows.stamp_ns, time_ns) for rows, time_ns in read] == [(10, 10), (11, 11)]
    assert read[0][0].local_id.tolist() == [1, 2, 3, 4, 10]


@pytest.mark.parametrize(('topic', 'kind'), [('/cam1/detections', Tracks), ('/site', Detections)])
def test_what_is_not_such_rows_is_named(bag, topic, kind):
    with BagReader(bag) as reader, pytest.raises(BagError, match=f'{topic} holds no'):
        list(reader.rows(topic, kind))


def test_a_bag_is_not_overwritten_unasked(bag):
    with pytest.raises(BagError, match=r'exists already.* by --overwrite'):
        BagWriter(bag)
    BagWriter(bag, overwrite=True).close()


def test_a_folder_that_is_no_bag_is_never_overwritten(tmp_path):
    (tmp_path / 'thesis.txt').write_text('mine')
    with pytest.raises(BagError, match='exists already and is no bag'):
        BagWriter(tmp_path, overwrite=True)
    assert (tmp_path / 'thesis.txt').read_text() == 'mine'


def test_a_missing_bag_is_named(tmp_path):
    with pytest.raises(BagError, match='nothing does not exist'):
        BagReader(tmp_path / 'nothing')


def test_an_empty_bag_is_refused(tmp_path):
    BagWriter(tmp_path / 'empty').close()
    with pytest.raises(BagError, match='holds no messages'):
        BagReader(tmp_path / 'empty')


def test_a_topic_that_is_not_there_is_named(bag):
    with BagReader(bag) as reader, pytest.raises(BagError, match='has no topic /cam9'):
        list(reader.messages(['/cam9']))


def test_an_unknown_message_type_is_named(bag):
    with (
        BagWriter(bag.parent / 'other') as writer,
        pytest.raises(BagError, match='acme/msg/Gadget'),
    ):
        writer.write_serialized('/gadget', 'acme/msg/Gadget', b'', 0)


def test_sqlite_bags_are_read_too(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY)
    message = cloud_from_rows(Detections.build(5), ROSBAGS_CLASSES, 'map')
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection(
            '/cam1/detections', message.__msgtype__, typestore=types
        )
        writer.write(connection, 5, types.serialize_cdr(message, message.__msgtype__))
    shutil.copytree(tmp_path / 'bag', tmp_path / 'moved')
    with BagReader(tmp_path / 'moved') as reader:
        assert [time_ns for _, _, time_ns in reader.messages()] == [5]


def test_topics_in_a_namespace_are_named_as_if_they_lay_in_none(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        for topic in ('/hall/site', '/site', '/hallway/site', '/note'):
            writer.write_text(topic, topic, 0)
    with BagReader(tmp_path / 'bag', '/hall') as reader:
        assert list(reader.topics) == ['/site', '/hallway/site', '/note']
        read = {topic: message.data for topic, message, _ in reader.messages()}
        assert read == {'/site': '/hall/site', '/hallway/site': '/hallway/site', '/note': '/note'}
        assert reader.count('/site') == reader.count('/hall/site') == 1
        with pytest.raises(BagError, match='has no topic /hall/tracks'):
            list(reader.messages(['/tracks']))


def test_offline_bags_state_the_quality_of_the_live_topics(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_text('/site', '{}', 0)
        writer.write_rows('/tracks', Tracks.build(0), 'map')
        writer.write_rows('/events', Events.build(0), 'map')
        image = np.zeros((4, 4, 3), np.uint8)
        writer.write('/cam1/image_raw', image_message(image, ROSBAGS_CLASSES, 0, ''), 0)
    metadata = yaml.safe_load((tmp_path / 'bag/metadata.yaml').read_text())
    forever = {'sec': 9223372036, 'nsec': 854775807}
    stated = {}
    for entry in metadata['rosbag2_bagfile_information']['topics_with_message_count']:
        (offered,) = entry['topic_metadata']['offered_qos_profiles']
        assert offered['reliability'] == 'reliable'
        assert offered['history'] == 'keep_last'
        assert offered['liveliness'] == 'automatic'
        assert offered['deadline'] == offered['lifespan'] == forever
        assert offered['liveliness_lease_duration'] == forever
        stated[entry['topic_metadata']['name']] = (offered['durability'], offered['depth'])
    assert stated == {
        '/site': ('transient_local', 1),
        '/tracks': ('volatile', 10),
        '/events': ('volatile', 100),
        '/cam1/image_raw': ('volatile', 8),
    }
