"""Detections of `vision_msgs` in bags, of both layouts of version 4 and both storages."""

from types import SimpleNamespace

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from typer.testing import CliRunner

from lens_cameras import SIZE, camera
from mctrack_ros.cli.main import app
from mctrack_ros.ground import write_calibration
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tables.vision_messages import ARRAY, read_detection_arrays

COMMON = {
    'Detection2DArray': 'std_msgs/Header header\nvision_msgs/Detection2D[] detections',
    'Detection2D': 'std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n'
    'vision_msgs/BoundingBox2D bbox\nstring id',
    'ObjectHypothesisWithPose': 'vision_msgs/ObjectHypothesis hypothesis\n'
    'geometry_msgs/PoseWithCovariance pose',
    'ObjectHypothesis': 'string class_id\nfloat64 score',
}
LAYOUTS = {
    '4.0': {'BoundingBox2D': 'geometry_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y'},
    '4.1': {
        'BoundingBox2D': 'vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y',
        'Pose2D': 'vision_msgs/Point2D position\nfloat64 theta',
        'Point2D': 'float64 x\nfloat64 y',
    },
}


def types_of(layout):
    types = get_typestore(Stores.ROS2_JAZZY)
    for name, text in {**COMMON, **LAYOUTS[layout]}.items():
        types.register(get_types_from_msg(text, f'vision_msgs/msg/{name}'))
    return types


def message(types, layout, stamp_ns, rows):
    """Return an array of (centre x, y, turn, width, height, results, id)."""
    made = SimpleNamespace(**{name.split('/')[-1]: each for name, each in types.types.items()})
    header = made.Header(
        stamp=made.Time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9), frame_id='optical'
    )
    pose = made.PoseWithCovariance(
        pose=made.Pose(
            position=made.Point(x=0.0, y=0.0, z=0.0),
            orientation=made.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0),
        ),
        covariance=np.zeros(36),
    )

    def centre(x, y, turn):
        if layout == '4.0':
            return types.types['geometry_msgs/msg/Pose2D'](x=x, y=y, theta=turn)
        pose_2d = types.types['vision_msgs/msg/Pose2D']
        return pose_2d(position=made.Point2D(x=x, y=y), theta=turn)

    detections = [
        made.Detection2D(
            header=header,
            results=[
                made.ObjectHypothesisWithPose(
                    hypothesis=made.ObjectHypothesis(class_id=name, score=score), pose=pose
                )
                for name, score in results
            ],
            bbox=made.BoundingBox2D(center=centre(x, y, turn), size_x=width, size_y=height),
            id=own,
        )
        for x, y, turn, width, height, results, own in rows
    ]
    return made.Detection2DArray(header=header, detections=detections)


def write(path, arrays, layout='4.1', storage=StoragePlugin.MCAP, topics=('/north/boxes',)):
    types = types_of(layout)
    with Writer(path, version=9, storage_plugin=storage) as writer:
        for topic in topics:
            connection = writer.add_connection(topic, ARRAY, typestore=types)
            for stamp_ns, rows in arrays:
                made = message(types, layout, stamp_ns, rows)
                writer.write(connection, stamp_ns, types.serialize_cdr(made, ARRAY))
    return path


PERSON = (25.0, 40.0, 0.0, 30.0, 40.0, [('dog', 0.2), ('person', 0.75)], '7')


@pytest.mark.parametrize('layout', LAYOUTS)
@pytest.mark.parametrize('storage', StoragePlugin)
def test_boxes_of_both_layouts_are_read(layout, storage, tmp_path):
    turned = (100.0, 50.0, np.pi / 2, 30.0, 40.0, [('car', 1.0)], '')
    arrays = [(10**9, [PERSON, turned]), (2 * 10**9, [])]
    seen = read_detection_arrays(write(tmp_path / 'bag', arrays, layout, storage), 'north')
    assert seen.stamp_ns.tolist() == [10**9, 2 * 10**9]
    np.testing.assert_allclose(seen.box, [[10, 20, 30, 40], [80, 35, 40, 30]])
    assert seen.score.tolist() == [0.75, 1.0]
    assert seen.label.tolist() == ['person', 'car']
    assert seen.local_id.tolist() == [1, 0]
    assert seen.interval_ns == 0.0


def test_the_camera_s_topic_is_found_or_asked_for(tmp_path):
    topics = ('/north/boxes', '/south/boxes')
    bag = write(tmp_path / 'bag', [(10**9, [PERSON])], topics=topics)
    assert len(read_detection_arrays(bag, 'south')) == 1
    assert len(read_detection_arrays(bag, 'east', '/north/boxes')) == 1
    with pytest.raises(BagError, match=r'2 topics hold .* name that of east'):
        read_detection_arrays(bag, 'east')
    with pytest.raises(BagError, match=r'has no vision_msgs/msg/Detection2DArray on /absent'):
        read_detection_arrays(bag, 'north', '/absent')


@pytest.mark.parametrize(
    ('arrays', 'said'),
    [
        ([(10**9, [PERSON]), (10**9, [])], r'message 2 .* has the stamp 1.000 s, after 1.000 s'),
        ([(0, [PERSON])], r'message 1 .* has the stamp 0.000 s, after more than 0'),
        ([(1, [(*PERSON[:5], [], '')])], r'message 1 .* has no result, so no score'),
        ([(1, [(*PERSON[:3], 0.0, *PERSON[4:])])], r'message 1 .*: a box is 0 x 40 px'),
        ([(1, [(*PERSON[:5], [('person', 80.0)], '')])], r'a score is 80, expected 0 to 1'),
    ],
)
def test_what_cannot_be_used_is_named_with_its_message(arrays, said, tmp_path):
    with pytest.raises(TableError, match=said):
        read_detection_arrays(write(tmp_path / 'bag', arrays), 'north')


@pytest.mark.parametrize('source', ['bag', 'bag/bag.mcap', 'bag:/north/boxes'])
def test_a_bag_of_them_is_imported_whole_or_as_a_file_or_by_topic(source, tmp_path):
    write_calibration(camera(), tmp_path / 'north.yaml', 'opencv', 'north')
    (tmp_path / 'hall.yaml').write_text(
        f'cameras: {{north: {{calibration: north.yaml, image_width: {SIZE[0]}, '
        f'image_height: {SIZE[1]}}}}}\n'
    )
    car = (300.0, 320.0, 0.0, 30.0, 60.0, [('car', 0.75)], '7')
    write(tmp_path / 'bag', [(10**9, [car]), (2 * 10**9, [])])
    command = ['import-detections', tmp_path / 'out', f'north={tmp_path / source}']
    result = CliRunner().invoke(app, [*map(str, command), '--site', str(tmp_path / 'hall.yaml')])
    assert 'north: 1 detections of 1 in 2 images, 1 of them empty' in result.output
    with BagReader(tmp_path / 'out') as reader:
        rows = [rows for rows, _ in reader.rows('/north/detections', Detections)]
    assert [each.stamp_ns for each in rows] == [10**9, 2 * 10**9]
    foot = camera().image_from_ground(rows[0].position[:, :2])
    np.testing.assert_allclose(foot, [[300, 350]], atol=0.1)
