"""The launch files: XML that says the same as Python, and nodes as their arguments ask for."""

import ast
from dataclasses import fields
from pathlib import Path
from xml.etree.ElementTree import parse

import pytest
import yaml

from mctrack_ros.cli import launch_files
from mctrack_ros.cli.launch_files import (
    GRAPH,
    REPLAY,
    SIMULATION,
    SITE,
    replay_specs,
    simulation_specs,
    site_specs,
)
from mctrack_ros.cli.launch_xml import FILES, write_launch_xml
from mctrack_ros.cli.sites import named_site, shipped_sites
from mctrack_ros.config import ConfigError
from mctrack_ros.resources import config_file
from mctrack_ros.ros.graph.launch_actions import moved_topics
from mctrack_ros.ros.nodes.simulator_node import SimulatorNodeConfig
from mctrack_ros.site.site import FILES as CAMERA_FILES

LAUNCH = Path(__file__).resolve().parents[2] / 'launch'


def given(arguments, **values):
    return {name: default for name, (default, _) in arguments.items()} | values


def test_xml_files_are_as_they_are_made(tmp_path):
    made = write_launch_xml(tmp_path)
    assert {path.name for path in made} == {path.name for path in LAUNCH.glob('*.xml')}
    for path in made:
        assert path.read_text() == (LAUNCH / path.name).read_text(), (
            'run python -m mctrack_ros.cli.launch_xml launch'
        )


@pytest.mark.parametrize('name', FILES)
def test_xml_passes_every_argument_to_a_python_file_that_is_there(name):
    root = parse(LAUNCH / f'{name}.launch.xml').getroot()
    include = root.find('include')
    folder, file = include.get('file').split('/')
    assert folder == '$(dirname)'
    source = (LAUNCH / file).read_text()
    functions = [each.name for each in ast.parse(source).body if isinstance(each, ast.FunctionDef)]
    assert functions == ['generate_launch_description']
    declared = [each.get('name') for each in root.findall('arg')]
    passed = {each.get('name'): each.get('value') for each in include.findall('arg')}
    assert passed == {each: f'$(var {each})' for each in declared}
    assert declared == list(FILES[name])


def test_all_that_start_a_graph_have_the_usual_arguments():
    for arguments in (SITE, REPLAY, SIMULATION):
        assert {'site', *GRAPH} <= arguments.keys()


def test_a_site_has_a_store_and_a_stream_where_they_are_asked_for(tmp_path):
    specs, why = site_specs(given(SITE, site='pitch5'))
    names = [spec.name for spec in specs]
    assert names == ['fusion', *(f'cam{k}_camera' for k in range(1, 6)), 'coverage']
    assert 'tracker' in why
    values = given(
        SITE, site='pitch5', store=str(tmp_path / 'a.db'), stream='8090', use_sim_time='yes'
    )
    specs, _ = site_specs(values)
    assert [spec.name for spec in specs][-2:] == ['store', 'stream']
    assert all(spec.parameters['use_sim_time'] is True for spec in specs)
    assert specs[-1].parameters['port'] == 8090


def test_a_replay_plays_the_images_alone(tmp_path):
    specs, _ = replay_specs(given(REPLAY, site='pitch5', bag=str(tmp_path), rate='2'))
    *nodes, player = specs
    assert all(spec.parameters['use_sim_time'] for spec in nodes)
    assert player.parameters['rate'] == 2.0
    assert player.ends
    assert r'/cam1/image_raw/compressed' in player.parameters['topics']
    assert not any('tracks' in each for each in player.parameters['topics'][:-1])


def test_own_detections_need_no_camera_nodes(tmp_path):
    specs, why = site_specs(given(SITE, site='hall', own_detections='true'))
    assert [spec.name for spec in specs] == ['fusion', 'coverage']
    assert 'own detections' in why
    assert specs[0].parameters['fusion']['tracker'] == 'joint'
    values = given(REPLAY, site='pitch5', bag=str(tmp_path), own_detections='true')
    (*nodes, player), _ = replay_specs(values)
    assert [spec.name for spec in nodes] == ['fusion', 'coverage']
    topics = player.parameters['topics']
    assert {'/cam1/detections', '/cam1/events', '/cam5/detections'} <= set(topics)
    assert not any('image' in each for each in topics)
    assert '.*/cam1/detections' in player.parameters['wait_for']


def test_a_site_of_cells_is_one_fusion_node(tmp_path):
    path = tmp_path / 'halls.yaml'
    path.write_text(yaml.safe_dump({'cells': ['north', 'south'], 'origin': '5,6'}))
    specs, why = site_specs(given(SITE, site=str(path), store=str(tmp_path / 'a.db')))
    assert [spec.name for spec in specs] == ['fusion', 'store']
    assert why == 'tracker cells: as the site says'
    fusion, store = (spec.parameters for spec in specs)
    assert list(fusion['cameras']) == store['cameras'] == ['north', 'south']
    assert fusion['fusion']['tracker'] == 'cells'
    assert fusion['site'] == str(path)
    assert fusion['origin'] == '5,6'
    (*nodes, player), _ = replay_specs(given(REPLAY, site=str(path), bag=str(tmp_path)))
    assert [spec.name for spec in nodes] == ['fusion']
    assert {'/north/tracks', '/south/feedback'} <= set(player.parameters['topics'])


def test_a_replay_plays_the_boxes_that_cameras_take(tmp_path):
    folder = Path(config_file('hall.yaml')).parent
    site = yaml.safe_load((folder / 'hall.yaml').read_text())
    for camera in site['cameras'].values():
        camera |= {each: str(folder / camera[each]) for each in set(CAMERA_FILES) & camera.keys()}
    name = min(site['cameras'])
    site['cameras'][name]['boxes_topic'] = 'boxes'
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(site))
    specs, _ = replay_specs(given(REPLAY, site=str(tmp_path / 'site.yaml'), bag=str(tmp_path)))
    topics = specs[-1].parameters['topics']
    assert f'/{name}/boxes' in topics
    assert not any(each.startswith(f'/{name}/image') for each in topics)


def test_a_replay_on_system_time_shifts_its_stamps(tmp_path):
    values = given(REPLAY, site='pitch5', bag=str(tmp_path), use_sim_time='false')
    *nodes, player = replay_specs(values)[0]
    assert not any(spec.parameters.get('use_sim_time') for spec in nodes)
    assert player.parameters['restamp']


@pytest.mark.parametrize('site', shipped_sites())
def test_every_shipped_site_is_simulated_as_the_scene_has_it(site):
    specs, _ = simulation_specs(given(SIMULATION, site=site, seed='7'))
    simulator = specs[-1]
    assert simulator.executable == 'simulator_node'
    assert simulator.parameters['seed'] == 7
    assert simulator.parameters.keys() - {'use_sim_time'} <= {
        each.name for each in fields(SimulatorNodeConfig)
    }
    assert simulator.parameters['cameras'] == list(named_site(site).camera_names)


def test_what_has_no_scene_is_not_simulated(tmp_path):
    with pytest.raises(ConfigError, match=r'expected one that is simulated: .*pitch5'):
        simulation_specs(given(SIMULATION, site=str(tmp_path / 'site.yaml')))


def test_rviz_shows_the_topics_of_a_namespace():
    view = config_file('mctrack.rviz').read_text()
    moved = dict(moved_topics(view, '/hall'))
    assert moved['/tf_static'] == '/hall/tf_static'
    assert moved['/tracks/markers'] == '/hall/tracks/markers'
    assert moved['/cam1/debug_image'] == '/hall/cam1/debug_image'
    assert moved_topics(view, '') == []


@pytest.mark.parametrize(('name', 'value'), [('stream', 'http'), ('use_sim_time', 'maybe')])
def test_a_wrong_value_names_its_argument(name, value):
    with pytest.raises(ConfigError, match=f"{name} is '{value}'"):
        site_specs(given(SITE, site='pitch5') | {name: value})
    assert launch_files.number_of('rate', '0.5') == 0.5
