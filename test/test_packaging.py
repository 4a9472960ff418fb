"""The package's files agree with one another, and an installed package finds its own."""

import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

from mctrack_ros import resources

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ('mctrack_ros', 'config', 'launch', 'resource')
FILES = ('setup.py', 'setup.cfg', 'package.xml', 'pyproject.toml')
EXECUTABLES = {
    'camera_node',
    'coverage_node',
    'stream_node',
    'fusion_node',
    'mctrack',
    'player',
    'recorder',
    'simulator_node',
    'store_node',
    'video_node',
}
ROSDEP_KEY_OF_IMPORT = {
    'backports': 'python3-rosbags-pip',
    'compression': 'python3-rosbags-pip',
    'cv2': 'python3-opencv',
    'defusedxml': 'python3-defusedxml',
    'jinja2': 'python3-jinja2',
    'lxml': 'python3-lxml',
    'lz4': 'python3-rosbags-pip',
    'markupsafe': 'python3-jinja2',
    'matplotlib': 'python3-matplotlib',
    'numba': 'python3-numba',
    'numpy': 'python3-numpy',
    'rich': 'python3-rich',
    'rosbags': 'python3-rosbags-pip',
    'scipy': 'python3-scipy',
    'shapely': 'python3-shapely',
    'typer': 'python3-typer',
    'yaml': 'python3-yaml',
}
TEST_KEY_OF_IMPORT = {'filterpy': 'python3-filterpy-pip', 'lifecycle_msgs': 'lifecycle_msgs'}
OF_READERS = {'floodlight', 'kloppy', 'movingpandas', 'pandas', 'pedpy'}
"""Other people's readers, which run in an environment of their own."""
REQUIREMENT_OF_IMPORT = {
    'cv2': 'opencv-python-headless',
    'jinja2': 'Jinja2',
    'paho': 'paho-mqtt',
    'yaml': 'PyYAML',
}
OF_THE_GRAPH = {'ros-jazzy-rclpy', 'ros-jazzy-common-interfaces'}
COMES_WITH = {
    *('rclpy', 'rcl_interfaces', 'builtin_interfaces', 'rosgraph_msgs'),  # rclpy
    *('diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs'),
    'visualization_msgs',  # as all these, common-interfaces
    *('backports', 'compression', 'lz4'),  # rosbags
    *('launch', 'launch_ros'),  # ros2 launch, which imports those modules
    'kloppy',  # an extra of the experiments
}
BY_NAME = {'tf2_msgs', 'ros2launch'}
WITHOUT_KEY = {
    'mcap',
    *('alembic', 'av', 'motmetrics', 'nicegui', 'psycopg', 'pyarrow', 'simplejpeg'),
    *('sqlalchemy', 'starlette', 'weasyprint', 'uvicorn', 'websockets', 'h11', 'paho'),
}


@pytest.fixture(scope='module')
def wheel(tmp_path_factory):
    copy = tmp_path_factory.mktemp('source')
    for name in SOURCES:
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns('__pycache__'))
    for name in FILES:
        shutil.copy(ROOT / name, copy / name)
    out = tmp_path_factory.mktemp('wheel')
    command = [sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '--no-build-isolation']
    subprocess.run([*command, '--no-index', '-w', str(out), str(copy)], check=True)
    return next(out.glob('*.whl'))


@pytest.fixture(scope='module')
def prefix(wheel, tmp_path_factory):
    path = tmp_path_factory.mktemp('prefix')
    command = [sys.executable, '-m', 'pip', 'install', '-q', '--no-deps', '--no-index']
    command += ['--ignore-installed', '--no-warn-script-location', '--prefix', str(path)]
    subprocess.run([*command, str(wheel)], check=True)
    return path


def test_manifest_is_an_ament_python_package_of_format_3():
    root = ElementTree.parse(ROOT / 'package.xml').getroot()
    assert root.get('format') == '3'
    assert root.findtext('export/build_type') == 'ament_python'
    assert root.findtext('license') == 'Apache-2.0'
    assert re.fullmatch(r'[\w.+-]+@[\w-]+\.[\w.-]+', root.find('maintainer').get('email'))


def test_manifest_and_setup_state_the_same_version():
    version = ElementTree.parse(ROOT / 'package.xml').getroot().findtext('version')
    assert f"version='{version}'" in (ROOT / 'setup.py').read_text()


def imported_by(*folders):
    """Return the top-level packages that the modules of folders import."""
    imported = set()
    for path in (path for folder in folders for path in (ROOT / folder).rglob('*.py')):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name.split('.')[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(node.module.split('.')[0])
    return imported - set(sys.stdlib_module_names) - {'mctrack_ros', 'mctrack_experiments'}


def test_manifest_depends_on_what_is_imported_and_on_nothing_else():
    manifest = ElementTree.parse(ROOT / 'package.xml').getroot()
    stated = {element.text for element in manifest.findall('exec_depend')}
    imported = imported_by('mctrack_ros', 'launch') - WITHOUT_KEY
    assert {ROSDEP_KEY_OF_IMPORT.get(name, name) for name in imported} == stated - BY_NAME


def test_readme_names_what_rosdep_does_not_install():
    text = (ROOT / 'README.md').read_text()
    asked = re.search(r'rosdep has no keys.*?`pip install ([^`]*)`', text, re.DOTALL)[1]
    named = {name.strip("'").removesuffix('[binary]') for name in asked.split()}
    assert named == {REQUIREMENT_OF_IMPORT.get(name, name) for name in WITHOUT_KEY}


def test_manifest_names_what_tests_import_beside_that():
    manifest = ElementTree.parse(ROOT / 'package.xml').getroot()
    stated = {element.text for element in manifest.findall('test_depend')}
    own = {path.stem for path in (ROOT / 'test').rglob('*')}
    imported = imported_by('test') - imported_by('mctrack_ros', 'launch') - own - OF_READERS
    keys = {TEST_KEY_OF_IMPORT.get(name, f'python3-{name}') for name in imported}
    assert keys == stated - {'python3-pytest-timeout'}


def test_manifest_keeps_the_order_of_its_schema():
    manifest = ElementTree.parse(ROOT / 'package.xml').getroot()
    order = ('name', 'version', 'description', 'maintainer', 'license', 'exec_depend')
    order += ('test_depend', 'export')
    places = [order.index(element.tag) for element in manifest]
    assert places == sorted(places)
    assert all(element.text.strip() for element in manifest.iter() if not len(element))


def test_requirements_are_what_is_imported_and_what_builds_and_tests():
    runs, tests = (ROOT / 'requirements.in').read_text().split('# What builds and tests it.')
    names = [set(re.findall(r'^[\w-]+', text, re.MULTILINE)) for text in (runs, tests)]
    imported = imported_by('mctrack_ros', 'launch', 'experiments/mctrack_experiments')
    imported = {REQUIREMENT_OF_IMPORT.get(name, name) for name in imported}
    assert names[0] - OF_THE_GRAPH == imported - COMES_WITH
    assert not names[1] & imported


def test_wheel_holds_what_ros2_run_and_launch_look_for(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = [name.split('.data/data/')[-1] for name in archive.namelist()]
    assert 'share/ament_index/resource_index/packages/mctrack_ros' in names
    assert 'share/mctrack_ros/package.xml' in names
    assert 'mctrack_ros/ground/calibration.xsd' in names
    assert 'mctrack_ros/streams/formats/trajectory.xsd' in names
    assert {f'lib/mctrack_ros/{name}' for name in EXECUTABLES} <= set(names)
    for folder in ('config', 'launch'):
        for path in (ROOT / folder).rglob('*.*'):
            if '__pycache__' not in path.parts:
                assert f'share/mctrack_ros/{path.relative_to(ROOT)}' in names


def test_installed_wrappers_lead_to_the_executables(prefix):
    for name in EXECUTABLES:
        wrapper = prefix / 'lib' / 'mctrack_ros' / name
        assert os.access(wrapper, os.X_OK)
        assert os.access(prefix / 'bin' / name, os.X_OK)


def test_an_installed_package_makes_a_trajectory_database(prefix):
    library = next(prefix.rglob('site-packages'))
    code = (
        'import mctrack_ros; print(mctrack_ros.__file__);'
        'from mctrack_ros.store import Database; Database("tracks.db", create=True)'
    )
    made = subprocess.run(
        [sys.executable, '-c', code],
        env={
            **os.environ,
            'PYTHONPATH': f'{library}{os.pathsep}{os.environ.get("PYTHONPATH", "")}',
        },
        cwd=prefix,
        capture_output=True,
        text=True,
    )
    assert made.stderr == ''
    assert str(prefix) in made.stdout
    assert (prefix / 'tracks.db').is_file()


def test_share_directory_is_found_in_a_checkout_and_in_a_prefix(prefix):
    assert resources.share_directory() == ROOT
    library = next(prefix.rglob('site-packages'))
    code = 'from mctrack_ros import resources; print(resources.share_directory())'
    found = subprocess.run(
        [sys.executable, '-c', code],
        env={**os.environ, 'PYTHONPATH': str(library)},
        cwd=prefix,
        capture_output=True,
        text=True,
        check=True,
    )
    assert Path(found.stdout.strip()) == prefix / 'share' / 'mctrack_ros'
