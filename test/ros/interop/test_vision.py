"""Boxes of other detectors in, as clouds or `vision_msgs` (stand-ins for it); tracks out."""

from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import Pose, PoseWithCovariance, Vector3
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from mctrack_ros.cli.sites import named_site
from mctrack_ros.interfaces import ClassCode, Detections, Tracks, TrackStatus
from mctrack_ros.ros.interop.boxes import detections_of, detections_of_cloud
from mctrack_ros.ros.interop.track_arrays import TrackArrays
from mctrack_ros.ros.nodes.camera_node import CameraNode
from walker import camera_parameters


def box(x, y, width, height, *results):
    return SimpleNamespace(
        results=[
            SimpleNamespace(hypothesis=SimpleNamespace(class_id=name, score=score))
            for name, score in results
        ],
        bbox=SimpleNamespace(
            center=SimpleNamespace(position=SimpleNamespace(x=x, y=y), theta=0.0),
            size_x=width,
            size_y=height,
        ),
        id='',
    )


def boxes(stamp_s, *detections):
    stamp = SimpleNamespace(sec=stamp_s, nanosec=5)
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp), detections=list(detections))


def cloud_of_boxes(rows, stamp_s=3, **fields):
    """Return boxes and what else is given, as a program in any language would send them."""
    columns = {'box': rows, **fields}
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    layout = [(name, array.dtype.str, array.shape[1:]) for name, array in arrays.items()]
    packed = np.zeros(len(rows), layout)
    for name, array in arrays.items():
        packed[name] = array
    message = PointCloud2(height=1, width=len(rows), point_step=packed.itemsize, is_dense=True)
    message.header.stamp.sec, message.row_step = stamp_s, packed.nbytes
    datatypes = {'<f4': PointField.FLOAT32, '<i4': PointField.INT32, '<u4': PointField.UINT32}
    for name, kind, shape in layout:
        offset, count = packed.dtype.fields[name][1], shape[0] if shape else 1
        field = PointField(name=name, offset=offset, datatype=datatypes[kind], count=count)
        message.fields.append(field)
    message.data = packed.tobytes()
    return message


def pitch_camera():
    return named_site('pitch5').cameras['cam1'].mapping()


def box_at(mapping, place):
    """Return the box of somebody who stands in a place, (1, 4) float32."""
    (foot,), (head,) = mapping.image_from_ground(place), mapping.image_from_ground(place, 1.7)
    height = foot[1] - head[1]
    return np.array([[head[0] - height / 6, head[1], height / 3, height]], np.float32)


def test_a_person_s_box_is_put_where_the_person_stands_with_covariance():
    place, mapping = np.array([[20.0, 25.0]]), pitch_camera()
    ((left, top, width, height),) = box_at(mapping, place)
    middle = left + width / 2, top + height / 2
    person = box(*middle, width, height, ('dog', 0.1), ('person', 0.8))
    other = box(*middle, height, height, ('giraffe', 0.9))
    rows = detections_of(boxes(3, person, other), mapping)
    assert rows.stamp_ns == 3_000_000_005
    np.testing.assert_allclose(rows.position[:, :2], place, atol=0.5)
    assert rows.class_id.tolist() == [ClassCode.PERSON]
    assert rows.score.tolist() == pytest.approx([0.8])
    assert (np.linalg.eigvalsh(rows.covariance) > 0).all()
    assert len(detections_of(boxes(4), mapping)) == 0


def test_a_box_without_a_result_is_refused():
    with pytest.raises(ValueError, match='detection 0: a detection has no result'):
        detections_of(boxes(3, box(9, 9, 5, 5)), pitch_camera())


def test_a_cloud_of_boxes_and_scores_alone_is_put_on_the_ground():
    place, mapping = np.array([[20.0, 25.0]]), pitch_camera()
    score = np.array([0.8], np.float32)
    rows = detections_of_cloud(cloud_of_boxes(box_at(mapping, place), score=score), mapping)
    np.testing.assert_allclose(rows.position[:, :2], place, atol=0.5)
    assert (rows.stamp_ns, rows.class_id.tolist()) == (3 * 10**9, [ClassCode.PERSON])
    assert (np.linalg.eigvalsh(rows.covariance) > 0).all()
    further = {'class_id': np.array([2], np.int32), 'local_id': np.array([7], np.uint32)}
    message = cloud_of_boxes(box_at(mapping, place), score=score, **further)
    rows = detections_of_cloud(message, mapping)
    assert (rows.class_id.tolist(), rows.local_id.tolist()) == ([ClassCode.VEHICLE], [7])
    nothing = cloud_of_boxes(np.zeros((0, 4), np.float32), score=np.zeros(0, np.float32))
    assert len(detections_of_cloud(nothing, mapping)) == 0


@pytest.mark.parametrize(
    ('boxes', 'fields', 'reason'),
    [
        ([[9, 9, 5, 5]], {}, "lacks the field 'score'"),
        ([[9, 9, 0, 5]], {'score': [0.5]}, 'not above 0'),
        ([[9, 9, np.nan, 5]], {'score': [0.5]}, 'not finite'),
        ([[9, 9, 5]], {'score': [0.5]}, r'expected \(n, 4\)'),
        ([[9, 9, 5, 5]], {'score': [1.5]}, 'not within 0 to 1'),
        ([[9, 9, 5, 5]], {'score': [[0.5, 0.5]]}, 'score has shape'),
        ([[9, 9, 5, 5]], {'score': [0.5], 'class_id': [np.nan]}, 'no whole numbers'),
    ],
)
def test_a_cloud_that_holds_no_boxes_is_refused(boxes, fields, reason):
    given = {name: np.array(values, np.float32) for name, values in fields.items()}
    message = cloud_of_boxes(np.array(boxes, np.float32), **given)
    with pytest.raises(ValueError, match=reason):
        detections_of_cloud(message, pitch_camera())


@pytest.mark.live
def test_a_camera_node_takes_clouds_of_boxes_in_place_of_images(bench, projection):
    parameters = camera_parameters(projection)
    parameters['settings'] |= {'boxes_topic': 'boxes', 'boxes_type': 'PointCloud2'}
    node = bench.make(CameraNode, **parameters)
    rows, boxes = bench.rows(Detections, '/cam1/detections'), np.array([[90, 40, 12, 36]], 'f4')
    publisher = bench.publisher(PointCloud2, '/cam1/boxes')
    bench.heard('/cam1/detections')
    publisher.publish(cloud_of_boxes(boxes, 3))
    bench.until(lambda: node.health.totals.get('refused'))
    publisher.publish(cloud_of_boxes(boxes, 4, score=np.array([0.7], 'f4')))
    bench.until(lambda: rows)
    assert (rows[0].stamp_ns, len(rows[0])) == (4 * 10**9, 1)
    np.testing.assert_array_equal(rows[0].box, boxes)


def kinds():
    """Return stand-ins for the classes of `vision_msgs`, made of rclpy's where these exist."""

    def array(header=None):
        return SimpleNamespace(header=header or Header(), detections=[])

    def result(pose=None):
        hypothesis = SimpleNamespace(class_id='', score=0.0)
        return SimpleNamespace(hypothesis=hypothesis, pose=pose or PoseWithCovariance())

    def bounding(center=None, size=None):
        return SimpleNamespace(center=center or Pose(), size=size or Vector3())

    return {
        'Detection3DArray': array,
        'Detection3D': SimpleNamespace,
        'BoundingBox3D': bounding,
        'ObjectHypothesisWithPose': result,
    }


def test_tracks_go_out_with_id_class_box_and_covariance():
    covariance = np.zeros((2, 4, 4))
    covariance[0, :2, :2] = [[0.09, 0.02], [0.02, 0.04]]
    tracks = Tracks.build(
        5 * 10**9,
        position=[[3.0, 4.0, 0.0], [9.0, 9.0, 0.0]],
        covariance=covariance,
        extent=[[np.nan, np.nan], [0.5, 1.8]],
        track_id=[12, 13],
        class_id=[ClassCode.PERSON, ClassCode.VEHICLE],
        score=[0.75, 1.0],
        status=[TrackStatus.CONFIRMED, TrackStatus.DELETED],
    )
    (one,) = TrackArrays(kinds()).array(tracks, 'map').detections
    assert (one.id, one.header.frame_id, one.header.stamp.sec) == ('12', 'map', 5)
    assert (one.bbox.size.x, one.bbox.size.z, one.bbox.center.position.z) == (0.5, 1.8, 0.9)
    (result,) = one.results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ('person', 0.75)
    spread = np.reshape(result.pose.covariance, (6, 6))
    np.testing.assert_allclose(spread[:2, :2], covariance[0, :2, :2], rtol=1e-6)
    assert np.count_nonzero(spread) == 4


def test_without_vision_msgs_a_node_that_is_to_take_boxes_says_so(bench, projection):
    parameters = camera_parameters(projection)
    parameters['settings']['boxes_topic'] = 'boxes'
    with pytest.raises(ValueError, match='not installed'):
        TrackArrays()
    bench.open('--params-file', str(bench.parameter_file('CameraNode', parameters)))
    node = CameraNode()
    bench.nodes.append(node)
    node.trigger_configure()
    node.trigger_activate()
    assert "'vision_msgs/msg/Detection2DArray' is not installed" in node.failure
