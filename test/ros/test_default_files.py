"""The shipped parameter files hold every parameter with its default, and nothing else."""

import pytest
import yaml

from mctrack_ros.config import config_from, values_of
from mctrack_ros.resources import config_file
from mctrack_ros.ros.default_files import NODE_CONFIGS, default_text, write_defaults

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
