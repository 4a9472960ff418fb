"""Build mctrack_ros with colcon (ament_python) or pip."""

import sys
from pathlib import Path

from setuptools import find_packages, setup

NAME = 'mctrack_ros'
NODES = (
    'camera_node',
    'fusion_node',
    'coverage_node',
    'stream_node',
    'store_node',
    'video_node',
    'simulator_node',
    'recorder',
    'player',
)
SCRIPTS = [f'{node} = {NAME}.ros.start:{node}' for node in NODES]
SCRIPTS.append(f'mctrack = {NAME}.cli.main:main')


def shared(folder):
    """Return data_files entries for a folder, its tree kept."""
    files = sorted(path for path in Path(folder).rglob('*') if path.is_file())
    parents = sorted({path.parent for path in files})
    return [
        (f'share/{NAME}/{parent}', [str(path) for path in files if path.parent == parent])
        for parent in parents
        if parent.name != '__pycache__'
    ]


def wrappers():
    """
    Return what `ros2 run` looks for, lib/mctrack_ros/<executable>, in a pip-installed prefix.

    pip puts executables into bin/ alone; colcon makes its own (setup.cfg).
    """
    if 'bdist_wheel' not in sys.argv:
        return []
    folder = Path('build') / 'wrappers'
    folder.mkdir(parents=True, exist_ok=True)
    names = [script.split()[0] for script in SCRIPTS]
    for name in names:
        wrapper = folder / name
        wrapper.write_text(f'#!/bin/sh\nexec "$(dirname "$0")/../../bin/{name}" "$@"\n')
        wrapper.chmod(0o755)
    return [(f'lib/{NAME}', [str(folder / name) for name in names])]


setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed', '**/*.html', '**/*.j2', '**/*.css', '**/*.js', '**/*.xsd']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        *shared('config'),
        *shared('launch'),
        *wrappers(),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    python_requires='>=3.11',
    zip_safe=True,
    maintainer='mctrack_ros developers',
    maintainer_email='mctrack@example.org',
    description='Multi-camera tracking on the ground plane as a ROS 2 node graph.',
    license='Apache-2.0',
    entry_points={'console_scripts': SCRIPTS},
)
