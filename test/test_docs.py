"""What the documents say is there: links, paths, columns, code, parameters, commands."""

import html
import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
import typer

from mctrack_ros.cli.main import app
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.recording.tables import box_files
from mctrack_ros.recording.tracks import track_table
from mctrack_ros.ros.parameter_table import parameter_page

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / 'docs'
NOTES = ROOT / 'experiments' / 'notes'
PAGES = [
    ROOT / 'README.md',
    ROOT / 'CONTRIBUTING.md',
    ROOT / 'QUALITY_DECLARATION.md',
    *sorted(DOCS.rglob('*.md')),
    *sorted(NOTES.rglob('*.md')),
]
FOLDERS = ('mctrack_ros', 'experiments', 'test', 'docs', 'config', 'launch')
SOURCES = sorted(
    path
    for folder in FOLDERS
    for path in (ROOT / folder).rglob('*')
    if path.suffix in {'.py', '.md', '.yaml', '.html', '.js', '.cpp'}
)
REFRESH = 'run: make reference'


def page_name(path):
    return str(path.relative_to(ROOT))


def anchors(page):
    """Return what links into a page may name: its headings as web sites spell them."""
    headings = re.findall(r'^#+ (.+)$', page, re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-') for heading in headings}


@pytest.mark.parametrize('path', PAGES, ids=page_name)
def test_every_link_leads_to_a_file_and_a_heading_that_are_there(path):
    for link in re.findall(r'\]\(([^)\s]+)\)', path.read_text()):
        if '://' in link:
            continue
        name, _, anchor = link.partition('#')
        target = path.parent / name if name else path
        assert target.exists(), link
        assert not anchor or anchor in anchors(target.read_text()), link


@pytest.mark.parametrize('path', [*PAGES, ROOT / 'CHANGELOG.rst'], ids=page_name)
def test_every_source_file_and_folder_that_a_page_names_is_there(path):
    known = {f'/{page_name(source)}' for source in SOURCES}
    packages = [folder.name for folder in (ROOT / 'mctrack_ros').iterdir() if folder.is_dir()]
    for name in re.findall(r'`([\w./-]+)`', path.read_text()):
        if name.endswith('.py'):
            is_there = (ROOT / name).exists() or any(one.endswith(f'/{name}') for one in known)
            assert is_there, name
        elif name.partition('/')[0] in FOLDERS and '/' in name:
            assert (ROOT / name).exists(), name
        elif name.partition('/')[0] in packages and name.endswith('/'):
            assert (ROOT / 'mctrack_ros' / name).is_dir(), name


def test_every_document_that_a_source_file_names_is_there():
    files = [*SOURCES, ROOT / 'Makefile', ROOT / 'CHANGELOG.rst', ROOT / 'package.xml']
    for source in files:
        for name in re.findall(r'\bdocs/[\w./-]*\w', source.read_text()):
            assert (ROOT / name).exists(), f'{source} names {name}'


@pytest.mark.parametrize('folder', ['tutorials', 'how-to', 'reference', 'explanation'])
def test_the_index_names_every_page(folder):
    index = (DOCS / 'README.md').read_text()
    for page in (DOCS / folder).glob('*.md'):
        assert f']({folder}/{page.name})' in index


def test_the_index_of_notes_names_every_note():
    index = (NOTES / 'README.md').read_text()
    assert all(f']({note.name})' in index for note in NOTES.glob('*.md') if note.stem != 'README')


def documented_columns(page):
    rows = re.findall(r'^\| ((?:or )?.*?`[a-z]\w*`.*?) \| (.*?) \| .* \|$', page, re.MULTILINE)
    names = re.findall(r'`([a-z0-9_]+)`', ' '.join(cell for row in rows for cell in row[:2]))
    return set(names)


@pytest.mark.parametrize(
    ('name', 'columns'),
    [
        ('how-to/own_detections.md', box_files.COLUMNS),
        ('how-to/evaluate.md', track_table.COLUMNS),
    ],
)
def test_every_column_is_documented_and_every_documented_one_is_read(name, columns):
    documented = documented_columns((DOCS / name).read_text())
    known = {one for column, more in columns.items() for one in (column, *more)}
    assert documented <= known
    assert set(columns) <= documented


@pytest.mark.parametrize(
    ('page', 'examples'),
    [
        ('own_detector.md', ('detector_node.py', 'position_node.py')),
        ('follow_a_person.md', ('follow_person.py',)),
    ],
)
def test_the_code_of_a_tutorial_is_that_of_its_examples(page, examples):
    blocks = re.findall(r'```python\n(.*?)```', (DOCS / 'tutorials' / page).read_text(), re.DOTALL)
    text = '\n'.join((DOCS / 'examples' / each).read_text() for each in examples)
    lines = [line.strip() for line in text.splitlines()]
    assert blocks
    for block in blocks:
        wanted = [line.strip() for line in block.splitlines()]
        starts = [row for row, line in enumerate(lines) if line == wanted[0]]
        assert any(lines[row : row + len(wanted)] == wanted for row in starts)


def test_the_documented_reader_reads_a_cloud():
    spec = importlib.util.spec_from_file_location(
        'read_cloud', DOCS / 'examples' / 'read_cloud.py'
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    tracks = Tracks.build(1, position=[[1, 2, 0], [3, 4, 0]], track_id=[7, 8], velocity=np.eye(2))
    fields = module.fields(cloud_from_rows(tracks, ROSBAGS_CLASSES, 'map'))
    assert fields['track_id'].tolist() == [7, 8]
    assert fields['x'].tolist() == [1.0, 3.0]
    assert fields['velocity'].tolist() == [[1.0, 0.0], [0.0, 1.0]]


def test_the_reference_of_parameters_is_that_of_the_code():
    assert (DOCS / 'reference' / 'parameters.md').read_text() == parameter_page(), REFRESH


def commands(group, name):
    """Yield every command below one, with its whole name."""
    yield name, group
    for each, command in getattr(group, 'commands', {}).items():
        yield from commands(command, f'{name} {each}')


def test_the_reference_of_commands_is_that_of_the_code():
    page = html.unescape((DOCS / 'reference' / 'command_line.md').read_text())
    sections = dict(re.findall(r'^##* `(mctrack.*?)`\n(.*?)(?=^##* |\Z)', page, re.M | re.S))
    found = dict(commands(typer.main.get_command(app), 'mctrack'))
    assert set(sections) == set(found), REFRESH
    for name, command in found.items():
        documented = set(re.findall(r'^\* `.*?(--[\w-]+)', sections[name], re.MULTILINE))
        options = {
            next(one for one in parameter.opts if one.startswith('--'))
            for parameter in command.params
            if parameter.opts[0].startswith('-')
        }
        assert documented - {'--help'} == options - {'--help'}, f'{name}: {REFRESH}'
        for parameter in command.params:
            assert (parameter.help or '') in sections[name], f'{name}: {REFRESH}'


@pytest.mark.parametrize('release', ['0.2.0', '0.1.0'])
def test_a_release_takes_fifteen_lines_of_the_changelog(release):
    changes = re.search(
        rf'^{release} .*?\n-+\n(.*?)(?=\n\n|\Z)', (ROOT / 'CHANGELOG.rst').read_text(), re.M | re.S
    )[1]
    assert len(changes.strip().splitlines()) <= 15
