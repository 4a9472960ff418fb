"""What is said of cameras that disagree."""

from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.ros.node.camera_agreement import agreements


def reports(bias):
    parts = agreements([f'cam{index + 1}' for index in range(len(bias.variance))], bias)
    return [health.report(name) for name, health in parts.items()]


def test_a_camera_that_lies_off_is_a_warning_in_metres():
    bias = CameraBias(3)
    bias.offset[2] = 0.0, -0.8
    bias.variance[1] = 0.25
    said = reports(bias)
    assert [status.name for status in said] == [f'cam{one} agreement' for one in (1, 2, 3)]
    levels = [DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.WARN]
    assert [status.level for status in said] == levels
    assert 'scatter by 0.50 m' in said[1].message
    assert 'lie 0.80 m from' in said[2].message


def test_of_two_cameras_nothing_is_said():
    assert reports(CameraBias(2)) == []
