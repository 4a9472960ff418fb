"""The views for RViz and Lichtblick can be read, and show topics that there are."""

import json
import re
from pathlib import Path

import yaml

from mctrack_ros.resources import config_file

ROOT = Path(__file__).resolve().parents[3]
TOPICS = (ROOT / 'docs' / 'reference' / 'topics.md').read_text()
NAMES = ('body', 'name', 'covariance', 'trail')


def described(topic):
    """Tell whether the reference names a topic."""
    general = re.sub(r'^/cam\d+/', '<camera>/', topic)
    return f'`{general}`' in TOPICS


def leaves(layout):
    """Return the panels of a layout's tree."""
    if isinstance(layout, str):
        return [layout]
    return leaves(layout['first']) + leaves(layout['second'])


def test_what_rviz_shows_is_published():
    content = yaml.safe_load(config_file('mctrack.rviz').read_text())
    manager = content['Visualization Manager']
    assert manager['Global Options']['Fixed Frame'] == 'map'
    shown = {each['Name']: each for each in manager['Displays']}
    assert len(shown) == len(manager['Displays'])
    topics = [each['Topic']['Value'] for each in shown.values() if 'Topic' in each]
    assert {'/tracks/markers', '/coverage', '/cam1/debug_image'} <= set(topics)
    assert [topic for topic in topics if not described(topic)] == []
    assert set(shown['Tracks']['Namespaces']) == set(NAMES)
    assert all(each['Class'].startswith('rviz_default_plugins/') for each in shown.values())


def test_what_lichtblick_shows_is_published_and_every_panel_is_set():
    content = json.loads(config_file('mctrack_lichtblick.json').read_text())
    panels = content['configById']
    assert sorted(leaves(content['layout'])) == sorted(panels)
    topics = list(panels['3D!tracks']['topics'])
    for name, panel in panels.items():
        if name.startswith('Image!'):
            topics += [panel['imageMode'][key] for key in ('imageTopic', 'calibrationTopic')]
    assert len(topics) > 6
    assert [topic for topic in topics if not described(topic)] == []
