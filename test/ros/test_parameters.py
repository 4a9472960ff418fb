"""A node whose parameters are wrong stops with one clear line and exit code 2."""

import pytest
from walker import camera_parameters

CASES = {
    'unknown': ('camera_node', {'peroid': 0.04}, 'unknown parameter peroid: was period meant?'),
    'unknown below': (
        'fusion_node',
        {'fusion': {'life': {'coast': 1.0}}},
        'unknown parameter fusion.life.coast',
    ),
    'wrong type': ('camera_node', {'depth': 'many'}, "depth is 'many', expected a whole number"),
    'out of range': ('camera_node', {'period': -1.0}, 'period is -1.0, expected 0.001 to 10.0'),
    'missing file': (
        'camera_node',
        {'settings': {'grid': '/nowhere.xml'}},
        '/nowhere.xml: No such file',
    ),
    'cameras twice': ('fusion_node', {'cameras': ['a', 'a']}, 'different names'),
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
def test_wrong_parameter_ends_the_node_with_one_line(bench, case):
    node, parameters, reason = CASES[case]
    process = bench.spawn(node, **parameters)
    assert bench.exit_code(process) == 2
    lines = bench.log(node).splitlines()
    assert len(lines) == 1
    assert reason in lines[0]


def test_broken_parameter_file_ends_the_node_with_one_line_of_ours(bench):
    path = bench.folder / 'broken.yaml'
    path.write_text('/**:\n  ros__parameters: [')
    process = bench.spawn('camera_node', '--params-file', str(path))
    assert bench.exit_code(process) == 2
    of_rcl, own = bench.log('camera_node').splitlines()
    assert '[rcl]' in of_rcl
    assert str(path) in own


def test_whole_number_serves_as_a_number(bench, projection):
    from mctrack_ros.ros.camera_node import CameraNode

    node = bench.make(CameraNode, **camera_parameters(projection, period=1))
    assert node.config.period == 1.0
