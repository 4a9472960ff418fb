"""The shipped parameter files hold every parameter with its default, and nothing else."""

import sys

import pytest
import yaml

from mctrack_ros.config import config_from, values_of
from mctrack_ros.fusion.motion.config import MOTION
from mctrack_ros.perception import CAMERA
from mctrack_ros.resources import config_file
from mctrack_ros.ros.default_files import NODE_CONFIGS, default_text, main, write_defaults

REFRESH = 'run: python -m mctrack_ros.ros.default_files config'


def plain(values):
    if isinstance(values, dict):
        return {name: plain(value) for name, value in values.items()}
    return list(values) if isinstance(values, tuple) else values


@pytest.mark.parametrize('node', NODE_CONFIGS)
def test_file_holds_each_parameter_with_its_default_and_no_other(node):
    content = yaml.safe_load(config_file(f'{node}.yaml').read_text())
    assert list(content) == ['/**']
    values = content['/**']['ros__parameters']
    assert values == plain(values_of(NODE_CONFIGS[node]())), REFRESH
    assert config_from(NODE_CONFIGS[node], values) == NODE_CONFIGS[node]()


@pytest.mark.parametrize('node', NODE_CONFIGS)
def test_file_says_what_each_parameter_is(node):
    assert config_file(f'{node}.yaml').read_text() == default_text(node), REFRESH


def test_all_files_are_written(tmp_path):
    names = {path.name for path in write_defaults(tmp_path)}
    assert names == {f'{node}.yaml' for node in NODE_CONFIGS}


def test_files_of_another_method_hold_its_parameters_and_are_read(tmp_path):
    chosen = {
        'settings.pipeline.local_tracker': 'silhouettes',
        'fusion.motion.model': 'interacting',
    }
    files = {path.stem: path.read_text() for path in write_defaults(tmp_path, chosen)}
    camera, fusion = (
        config_from(NODE_CONFIGS[node], yaml.safe_load(files[node])['/**']['ros__parameters'])
        for node in ('camera_node', 'fusion_node')
    )
    assert camera.settings.pipeline == CAMERA.made('silhouettes')
    assert fusion.fusion.motion == MOTION.made('interacting')
    assert 'local_tracker=event_tracker' in files['camera_node']


def test_the_shipped_file_says_how_to_see_those_of_another_method():
    text = config_file('camera_node.yaml').read_text()
    assert 'default_files /tmp --set settings.pipeline.local_tracker=silhouettes' in text


def test_a_name_that_chooses_nothing_is_refused(monkeypatch, capsys):
    monkeypatch.setattr(sys, 'argv', ['default_files', '/nowhere', '--set', 'fusion.model=none'])
    with pytest.raises(SystemExit):
        main()
    assert 'fusion.model names no method' in capsys.readouterr().err
