"""Lifecycle: nodes that wait to be told, go back and forth, and refuse what is wrong."""

import pytest
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import DescribeParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import CompressedImage

from mctrack_ros.interfaces import Detections
from mctrack_ros.ros.nodes.camera_node import CameraNode
from walker import camera_parameters, walker_message

pytestmark = pytest.mark.live


def call(bench, kind, service, request):
    client = bench.observer.create_client(kind, service)
    bench.until(client.service_is_ready)
    future = client.call_async(request)
    bench.until(future.done)
    return future.result()


def change(bench, transition):
    request = ChangeState.Request(transition=Transition(id=transition))
    return call(bench, ChangeState, '/camera_node/change_state', request).success


def state(bench):
    return call(bench, GetState, '/camera_node/get_state', GetState.Request()).current_state.id


@pytest.fixture
def waiting(bench, projection):
    return bench.make(CameraNode, **camera_parameters(projection, autostart=False))


def test_node_that_does_not_start_itself_goes_through_its_states(bench, waiting):
    steps = (
        (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
        (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
        (Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE),
        (Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED),
        (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
        (Transition.TRANSITION_INACTIVE_SHUTDOWN, State.PRIMARY_STATE_FINALIZED),
    )
    assert state(bench) == State.PRIMARY_STATE_UNCONFIGURED
    for transition, expected in steps:
        assert change(bench, transition)
        assert state(bench) == expected


def test_only_an_active_node_receives(bench, waiting):
    detections = bench.rows(Detections, '/cam1/detections')
    images = bench.observer.create_publisher(CompressedImage, '/cam1/image_raw/compressed', 10)
    waiting.trigger_configure()
    bench.heard('/cam1/detections')
    assert bench.observer.count_subscribers('/cam1/image_raw/compressed') == 0
    waiting.trigger_activate()
    bench.until(lambda: images.get_subscription_count() == 1)
    images.publish(walker_message(0, 10**18))
    bench.until(lambda: detections)
    waiting.trigger_deactivate()
    bench.until(lambda: images.get_subscription_count() == 0)


def test_failed_configuration_leaves_the_node_unconfigured(bench, waiting):
    missing = Parameter('settings.calibration', value='/nowhere/projection.yaml')
    assert waiting.set_parameters([missing])[0].successful
    assert not change(bench, Transition.TRANSITION_CONFIGURE)
    assert '/nowhere/projection.yaml' in waiting.failure
    assert state(bench) == State.PRIMARY_STATE_UNCONFIGURED


def test_parameters_change_only_before_configuration_and_only_to_what_is_valid(waiting):
    assert waiting.set_parameters([Parameter('period', value=0.1)])[0].successful
    assert not waiting.set_parameters([Parameter('period', value=-1.0)])[0].successful
    assert not waiting.set_parameters([Parameter('period', value='fast')])[0].successful
    waiting.trigger_configure()
    assert waiting.config.period == 0.1
    refused = waiting.set_parameters([Parameter('period', value=0.2)])[0]
    assert not refused.successful
    assert 'clean the node up' in refused.reason


def test_parameters_are_described_with_their_ranges(bench, waiting):
    request = DescribeParameters.Request(names=['period', 'depth', 'camera'])
    period, depth, camera = call(
        bench, DescribeParameters, '/camera_node/describe_parameters', request
    ).descriptors
    assert period.type == ParameterType.PARAMETER_DOUBLE
    assert period.floating_point_range[0].from_value == 0.001
    assert depth.integer_range[0].to_value == 1000
    assert 'camera' in camera.description
