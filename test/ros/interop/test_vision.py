"""`vision_msgs`: boxes of other detectors in, tracks out; of rosbags' types, as they lack here."""

from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import Pose, PoseWithCovariance, Vector3
from std_msgs.msg import Header

from mctrack_ros.cli.sites import named_site
from mctrack_ros.interfaces import ClassCode, Tracks, TrackStatus
from mctrack_ros.ros.interop.boxes import detections_of
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


def test_a_person_s_box_is_put_where_the_person_stands_with_covariance():
    mapping = named_site('pitch5').cameras['cam1'].mapping()
    place = np.array([[20.0, 25.0]])
    (foot,), (head,) = mapping.image_from_ground(place), mapping.image_from_ground(place, 1.7)
    middle, height = (foot + head) / 2, foot[1] - head[1]
    person = box(*middle, height / 3, height, ('dog', 0.1), ('person', 0.8))
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
        detections_of(boxes(3, box(9, 9, 5, 5)), named_site('pitch5').cameras['cam1'].mapping())


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
