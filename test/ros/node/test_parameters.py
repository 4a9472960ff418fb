"""A node whose parameters are wrong stops with one clear line and exit code 2."""

import pytest
import yaml
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from mctrack_ros.config import nested
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.nodes.player import Player
from mctrack_ros.ros.nodes.recorder import Recorder
from walker import camera_parameters

CASES = {
    'unknown': ('camera_node', {'peroid': 0.04}, 'unknown parameter peroid: was period meant?'),
    'unknown below': (
        'fusion_node',
        {'fusion': {'management': {'coast': 1.0}}},
        'unknown parameter fusion.management.coast',
    ),
    'of another method': (
        'camera_node',
        {'settings': {'pipeline': {'silhouettes': {'holes': {'still_s': 2.0}}}}},
        'settings.pipeline.silhouettes.holes.still_s belongs to local_tracker silhouettes, but '
        'settings.pipeline.local_tracker is event_tracker',
    ),
    'no method': (
        'fusion_node',
        {'fusion': {'tracker': 'none'}},
        "fusion.tracker is 'none', expected one of "
        "['joint', 'occupancy', 'vehicles', 'likelihood_grid', 'belief', 'cells']",
    ),
    'wrong type': ('camera_node', {'depth': 'many'}, "depth is 'many', expected a whole number"),
    'out of range': ('camera_node', {'period': -1.0}, 'period is -1.0, expected 0.001 to 10.0'),
    'missing file': (
        'camera_node',
        {'settings': {'grid': '/nowhere.xml'}},
        '/nowhere.xml: No such file',
    ),
    'cameras twice': ('fusion_node', {'cameras': ['a', 'a']}, 'different names'),
    'no place for ids': (
        'fusion_node',
        {'state_file': '/dev/null/ids.json'},
        'state_file /dev/null/ids.json: ',
    ),
    'no bag': ('player', {'path': '/nowhere/bag'}, '/nowhere/bag does not exist'),
    'no path': ('recorder', {}, 'path is empty'),
    'bad expression': (
        'recorder',
        {'path': '/tmp/never_made', 'topics': ['(']},
        'not a regular expression',
    ),
    'no source': ('video_node', {'source': '/nowhere.avi'}, '/nowhere.avi does not exist'),
}


@pytest.mark.parametrize('case', CASES)
def test_wrong_parameter_ends_the_node_with_one_line(refusal, case):
    node, parameters, reason = CASES[case]
    (line,) = refusal(node, **parameters)
    assert reason in line


def test_broken_parameter_file_ends_the_node_with_one_line_of_ours(bench):
    path = bench.folder / 'broken.yaml'
    path.write_text('/**:\n  ros__parameters: [')
    process = bench.spawn('camera_node', '--params-file', str(path))
    assert bench.exit_code(process) == 2
    of_rcl, own = bench.log('camera_node').splitlines()
    assert '[rcl]' in of_rcl
    assert str(path) in own


def test_whole_number_serves_as_a_number(bench, projection):
    from mctrack_ros.ros.nodes.camera_node import CameraNode

    node = bench.make(CameraNode, **camera_parameters(projection, period=1))
    assert node.config.period == 1.0


@pytest.fixture
def dumped(bench):
    """Return a function that makes and configures a node; a client, and a file of its dump."""

    def make(kind, **parameters):
        node = bench.make(kind, autostart=False, **parameters)
        node.trigger_configure()
        assert not node.failure
        name = node.get_fully_qualified_name()
        client = AsyncParameterClient(bench.observer, name)

        def answer(future):
            bench.until(future.done)
            return future.result()

        bench.until(client.services_are_ready)
        names = sorted(answer(client.list_parameters()).result.names)
        values = [
            parameter_value_to_python(v) for v in answer(client.get_parameters(names)).values
        ]
        flat = dict(zip(names, [list(v) if isinstance(v, list) else v for v in values]))
        path = bench.folder / 'dump.yaml'
        path.write_text(yaml.dump({name: {'ros__parameters': nested(flat)}}))
        return flat, path, lambda file: answer(client.load_parameter_file(str(file))).results

    return make


TINY = {'cameras': ['cam1', 'cam2'], 'fusion': {'association': {'false_density': 1e-05}}}


@pytest.mark.live
@pytest.mark.parametrize('kind', [FusionNode, Player, Recorder])
def test_a_node_takes_what_it_told_of_its_parameters_as_param_load_hands_it_over(
    dumped, kind, walker_bag, tmp_path
):
    path = {Player: walker_bag, Recorder: tmp_path / 'out'}
    settings = TINY if kind is FusionNode else {'path': str(path[kind])}
    flat, file, load = dumped(kind, **settings)
    assert {'use_sim_time', 'start_type_description_service', 'autostart'} <= flat.keys()
    results = load(file)
    assert len(results) == len(flat)
    assert [result.reason for result in results if not result.successful] == []


@pytest.mark.live
def test_a_node_that_is_configured_refuses_what_differs_from_its_dump(dumped):
    _, file, load = dumped(FusionNode, **TINY)
    file.write_text(file.read_text().replace('ground_frame: map', 'ground_frame: hall'))
    (refused,) = (result for result in load(file) if not result.successful)
    assert 'ground_frame takes effect on configuration' in refused.reason


@pytest.mark.live
def test_a_dump_serves_as_the_parameter_file_of_a_new_node(bench, dumped):
    _, file, _ = dumped(FusionNode, use_sim_time=True, state_file='', **TINY)
    file.write_text(file.read_text().replace('/fusion_node:', '/hall/fusion_node:'))
    process = bench.spawn('fusion_node', '--params-file', str(file), '-r', '__ns:=/hall')
    spawned = ('fusion_node', '/hall')
    listed = bench.observer.get_node_names_and_namespaces
    bench.until(lambda: spawned in listed(), patience_s=60)
    process.terminate()
    assert bench.exit_code(process) == 0
    assert bench.log('fusion_node') == ''


def test_a_method_named_before_configuration_brings_its_parameters(bench, projection):
    from mctrack_ros.ros.nodes.camera_node import CameraNode

    node = bench.make(CameraNode, autostart=False, **camera_parameters(projection))
    gone, come = (
        'settings.pipeline.blobs.halo_share',
        'settings.pipeline.silhouettes.holes.still_s',
    )
    assert node.has_parameter(gone)
    assert not node.has_parameter(come)
    choice = Parameter('settings.pipeline.local_tracker', value='silhouettes')
    assert node.set_parameters([choice])[0].successful
    assert not node.has_parameter(gone)
    assert node.get_parameter(come).value == 1.0
    assert not node.set_parameters([Parameter(come, value=-1.0)])[0].successful
    assert node.set_parameters([Parameter(come, value=2.0)])[0].successful
    node.trigger_configure()
    assert not node.failure
    assert node.config.settings.pipeline.silhouettes.holes.still_s == 2.0
    refused = node.set_parameters([Parameter(choice.name, value='event_tracker')])[0]
    assert 'takes effect on configuration' in refused.reason
