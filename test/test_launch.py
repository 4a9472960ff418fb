"""The launch files name only arguments, files and executables that there are."""

import ast
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from test_packaging import EXECUTABLES

LAUNCH = Path(__file__).resolve().parents[1] / 'launch'
XML = sorted(LAUNCH.glob('*.xml'))
OF_A_SITE = (
    *('site', 'namespace', 'params_file', 'use_sim_time', 'autostart', 'log_level', 'rviz'),
    *('respawn', 'stream', 'store'),
)


def arguments_of_site():
    tree = ast.parse((LAUNCH / 'site.launch.py').read_text())
    for node in tree.body:
        if isinstance(node, ast.Assign) and node.targets[0].id == 'ARGUMENTS':
            return set(ast.literal_eval(node.value))
    raise AssertionError('site.launch.py states no ARGUMENTS')


def test_a_site_is_launched_with_the_usual_arguments():
    assert arguments_of_site() == set(OF_A_SITE)


@pytest.mark.parametrize('path', XML, ids=lambda path: path.stem)
def test_an_xml_file_uses_what_it_declares_and_declares_what_it_uses(path):
    root = ElementTree.parse(path).getroot()
    declared = {each.get('name') for each in root.findall('arg')}
    used = set(re.findall(r'\$\(var (\w+)\)', path.read_text()))
    assert used == declared
    for node in root.iter('node'):
        assert node.get('pkg') == 'mctrack_ros'
        assert node.get('exec') in EXECUTABLES


@pytest.mark.parametrize('name', ['tracking', 'replay', 'simulation'])
def test_an_xml_file_passes_on_all_arguments_of_a_site(name):
    include = ElementTree.parse(LAUNCH / f'{name}.launch.xml').getroot().find('include')
    file = include.get('file').removeprefix('$(dirname)/')
    assert (LAUNCH / file).is_file()
    assert {each.get('name') for each in include.findall('arg')} == arguments_of_site()
