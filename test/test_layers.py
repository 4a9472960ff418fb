"""Imports run one way through the package."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / 'mctrack_ros'

ALLOWED = {
    'interfaces': set(),
    'config': set(),
    'compiled': set(),
    'resources': set(),
    'processes': set(),
    'input_size': set(),
    'site.names': {'config'},
    'site.description': {'interfaces'},
    'site.stated_origin': {'config'},
    'site.plan': {'config'},
    'ground': {'interfaces', 'config', 'compiled', 'input_size'},
    'zones': {'interfaces', 'config', 'ground'},
    'site.origin': {'config', 'ground', 'site.stated_origin', 'zones'},
    'tracking': {'interfaces', 'config', 'compiled', 'ground'},
    'perception': {'interfaces', 'config', 'compiled', 'ground', 'tracking'},
    'fusion': {'interfaces', 'config', 'compiled', 'ground', 'tracking'},
    'codec': {'interfaces'},
}
ALLOWED['site.camera'] = ALLOWED['perception'] | {
    'perception',
    'site.origin',
    'site.stated_origin',
    'zones',
    'input_size',
}
ALLOWED['site.site'] = ALLOWED['site.camera'] | {
    'site.names',
    'site.camera',
    'site.description',
    'site.plan',
    'fusion',
}
ALLOWED['site.choice'] = ALLOWED['site.site'] | {'site.site'}
ALLOWED['site.coverage'] = ALLOWED['site.site'] | {'site.site'}
ALLOWED['site.portable'] = ALLOWED['site.site'] | {'site.site'}
ALLOWED['recording'] = {'interfaces', 'config', 'codec', 'input_size'}
ALLOWED['store'] = {'interfaces', 'codec', 'recording', 'zones'}
ALLOWED['streams'] = ALLOWED['store'] | {'store', 'config', 'input_size'}
ALLOWED['replay'] = ALLOWED['site.choice'] | {
    *('site.choice', 'site.portable'),
    *('codec', 'recording', 'processes'),
}
ALLOWED['evaluation'] = {
    'interfaces',
    'config',
    'ground',
    'recording',
    'site.origin',
    'site.stated_origin',
}
ALLOWED['simulation'] = {'interfaces', 'codec', 'recording', 'ground', 'processes'}
ALLOWED['explain'] = ALLOWED['replay'] | {'replay'}
ALLOWED['report'] = ALLOWED['explain'] | {'simulation', 'evaluation', 'site.coverage', 'store'}
ALLOWED['ros'] = ALLOWED['report'] | {'resources', 'streams', 'input_size'}
ALLOWED['web'] = ALLOWED['ros'] | {'ros', 'report'}
ALLOWED['cli'] = ALLOWED['web'] | {'web', 'report', 'explain'}

STAGES = {
    'ground': (
        ('errors', 'mapping', 'origin', 'support', 'yaml_files'),
        ('xml_files', 'coverage', 'homography'),
        ('camera',),
        ('plausible', 'files.keyed'),
        ('grid',),
        ('files',),
    ),
    'perception': (
        ('config', 'foreground', 'image_clock', 'image_state', 'camera_shift', 'geometry'),
        ('output', 'blobs'),
        ('blob_split', 'feedback', 'front_end'),
        ('local_tracks',),
        ('background', 'events'),
        ('silhouettes', 'likelihood_grid', 'moving_camera'),
        ('event_tracker',),
        ('belief',),
        ('trackers', 'boxes', 'overlay', 'mosaic'),
    ),
    'fusion': (
        ('clock_offsets.config',),
        ('config', 'columns', 'inputs', 'neighbours', 'views', 'association.solvers'),
        ('motion.config', 'association.config', 'existence.config', 'reid.config'),
        ('management.config',),
        ('joint_tracker.config',),
        ('camera_clocks', 'clock_offsets', 'table', 'measurements'),
        ('batcher', 'motion', 'sensor_bias'),
        ('existence', 'association', 'reid'),
        ('update',),
        ('management',),
        ('joint_tracker',),
        ('occupancy',),
        ('likelihood_grid', 'belief', 'cells'),
        ('explain',),
        ('trackers',),
    ),
}
"""Inside a layer: each stage may import those of the floors above its own in this list."""
ROS_PACKAGES = {'rclpy', 'lifecycle_msgs', 'rcl_interfaces', 'ament_index_python', 'launch'}


def layer_of(name):
    """Return the layer of a module, by its name inside the package."""
    inside = [layer for layer in ALLOWED if name == layer or name.startswith(f'{layer}.')]
    return max(inside, key=len, default=None)


def imported_names(path, types_too=True):
    """Yield what a module imports; types too: also what only its annotations name."""
    tree = ast.parse(path.read_text())
    checks = [node for node in tree.body if isinstance(node, ast.If)] if not types_too else []
    only_types = {id(each) for node in checks for each in ast.walk(node)}
    for node in ast.walk(tree):
        if id(node) in only_types:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: a relative import'
            yield node.module or ''


@pytest.mark.parametrize('layer', ALLOWED)
def test_layer_imports_only_what_lies_below(layer):
    for path in PACKAGE.rglob('*.py'):
        own = '.'.join(path.relative_to(PACKAGE).with_suffix('').parts)
        if path.name == '__init__.py' and path.parent in (PACKAGE, PACKAGE / 'site'):
            assert not list(imported_names(path))
            continue
        assert layer_of(own), f'{path} is of no layer'
        if layer_of(own) != layer:
            continue
        for name in imported_names(path):
            top, _, rest = name.partition('.')
            if top == 'mctrack_ros' and rest:
                other = layer_of(rest)
                assert other == layer or other in ALLOWED[layer], f'{path} imports {name}'
            is_ros = top in ROS_PACKAGES or top.endswith('_msgs')
            assert layer == 'ros' or not is_ros, f'{path} imports {name}'
            assert top != 'mctrack_experiments', f'{path} imports {name}'


def stage_of(layer, name):
    """Return floor and stage of a module, by its name inside a layer."""
    stages = [(floor, each) for floor, row in enumerate(STAGES[layer]) for each in row]
    inside = [each for each in stages if name == each[1] or name.startswith(f'{each[1]}.')]
    return max(inside, key=lambda each: len(each[1]), default=None)


@pytest.mark.parametrize('layer', STAGES)
def test_stages_import_only_what_lies_below(layer):
    for path in (PACKAGE / layer).rglob('*.py'):
        parts = path.relative_to(PACKAGE / layer).with_suffix('').parts
        if parts == ('__init__',):
            continue
        name = '.'.join(part for part in parts if part != '__init__')
        own = stage_of(layer, name)
        assert own, f'{path} is of no stage'
        for imported in imported_names(path, types_too=False):
            if imported.startswith(f'mctrack_ros.{layer}.'):
                other = stage_of(layer, imported.removeprefix(f'mctrack_ros.{layer}.'))
                assert other, f'{path} imports {imported}'
                assert other == own or other[0] < own[0], f'{path} imports {imported}'


def test_no_folder_holds_more_than_thirteen_modules():
    for folder in [PACKAGE, *(path for path in PACKAGE.rglob('*') if path.is_dir())]:
        modules = [path for path in folder.glob('*.py') if path.stem != '__init__']
        assert len(modules) <= 13, folder


def arguments(function):
    given = function.args
    named = [each.arg for each in given.posonlyargs + given.args + given.kwonlyargs]
    return len(set(named) - {'self', 'cls'})


def is_compiled(function):
    marks = (each.func if isinstance(each, ast.Call) else each for each in function.decorator_list)
    return any(
        isinstance(mark, ast.Name) and mark.id in {'compiled', 'inner', 'inlined'}
        for mark in marks
    )


def test_no_function_takes_more_than_eight_arguments():
    commands = PACKAGE / 'cli' / 'commands'  # their arguments are the command line's
    long = {
        f'{path.relative_to(PACKAGE)}:{node.lineno} {node.name}'
        for path in PACKAGE.rglob('*.py')
        if commands not in path.parents
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef) and not is_compiled(node) and arguments(node) > 8
    }
    assert not long


@pytest.mark.parametrize(
    ('modules', 'kept_out'),
    [
        (['replay.workers', 'ros.nodes.camera_node'], {'fusion'}),
        (['ros.nodes.fusion_node'], {'perception', 'ground'}),
        (
            [
                *('cli.main', 'ros.start', 'ros.graph', 'ros.nodes.player', 'ros.nodes.recorder'),
                *('ros.nodes.video_node', 'ros.nodes.simulator_node'),
            ],
            {'perception', 'ground', 'fusion', 'compiled'},
        ),
    ],
)
def test_a_process_loads_no_more_than_it_needs(modules, kept_out):
    names = [f'mctrack_ros.{module}' for module in modules]
    told = f'import {", ".join(names)}, sys; print(*sys.modules, sep="\\n")'
    done = subprocess.run(
        [sys.executable, '-c', told], cwd=PACKAGE.parent, capture_output=True, text=True
    )
    assert set(names) <= set(done.stdout.splitlines()), done.stderr
    loaded = {
        name.split('.')[1] for name in done.stdout.split() if name.startswith('mctrack_ros.')
    }
    assert not kept_out & loaded
