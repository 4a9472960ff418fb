"""Two machines, network namespaces that only a cable joins: images in one, fusion in the other."""

import os
import re
import shutil
import subprocess
import sys
import time

import pytest
import yaml

from ros_domains import free_domain
from walker import camera_parameters

pytestmark = [pytest.mark.live, pytest.mark.timeout(300)]

PATIENCE_S = 100.0
CAMERA, FUSION = '10.213.4.1', '10.213.4.2'
PORT = 11811
LARGE_DATA = 'LARGE_DATA?max_msg_size=4MB&sockets_size=4MB'


def run(*command):
    return subprocess.run(command, capture_output=True, text=True)


class Machine:
    """A network namespace with an address, and shared memory of its own."""

    def __init__(self, name, folder):
        self.folder = folder
        own = 'mount -t tmpfs tmpfs /dev/shm && echo && exec sleep infinity'
        self.holder = subprocess.Popen(
            ['ip', 'netns', 'exec', name, 'sh', '-c', own], stdout=subprocess.PIPE
        )
        self.holder.stdout.readline()
        self.processes = [self.holder]

    def start(self, label, *command, **environment):
        """Start a command there; what it says goes to a file."""
        inside = ['nsenter', '-t', str(self.holder.pid), '-m', '-n', *command]
        with open(self.folder / f'{label}.log', 'w') as log:
            process = subprocess.Popen(
                inside,
                env=os.environ | environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )
        self.processes.append(process)

    def node(self, node, environment, **parameters):
        """Start a node with parameters."""
        path = self.folder / f'{node}.yaml'
        path.write_text(yaml.safe_dump({'/**': {'ros__parameters': parameters}}))
        module = ['-m', f'mctrack_ros.ros.nodes.{node}', '--ros-args', '--params-file', str(path)]
        self.start(node, sys.executable, *module, **environment)

    def stop(self):
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def machines(tmp_path, monkeypatch):
    """Return two of them that a cable without multicast joins, or leave the test out."""
    if shutil.which('ip') is None:
        pytest.skip('ip is not installed: apt install iproute2')
    names = [f'mctrack{os.getpid()}{end}' for end in 'ab']
    cables = [f'mct{os.getpid() % 100000}{end}' for end in 'ab']
    refused = [done.stderr for done in (run('ip', 'netns', 'add', name) for name in names)]
    made = []
    try:
        if any(refused):
            pytest.skip(f'network namespaces are not permitted here: {"".join(refused).strip()}')
        cabled = run('ip', 'link', 'add', cables[0], 'type', 'veth', 'peer', 'name', cables[1])
        if cabled.returncode:
            pytest.skip(f'veth is not permitted here: {cabled.stderr.strip()}')
        for name, cable, address in zip(names, cables, (CAMERA, FUSION)):
            inside = ['ip', '-n', name]
            for command in (
                ['ip', 'link', 'set', cable, 'netns', name],
                [*inside, 'address', 'add', f'{address}/24', 'dev', cable],
                [*inside, 'link', 'set', cable, 'multicast', 'off', 'up'],
                [*inside, 'link', 'set', 'lo', 'up'],
            ):
                subprocess.run(command, check=True)
        made += [Machine(name, tmp_path) for name in names]
        with free_domain() as domain:
            monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
            monkeypatch.setenv('ROS_HOME', str(tmp_path / 'ros_home'))
            yield made
    finally:
        for machine in made:
            machine.stop()
        for name in names:
            run('ip', 'netns', 'delete', name)


def static_peers(machines):
    """Return what each machine needs to find the other one by its address."""
    found = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    return [found | {'ROS_STATIC_PEERS': other} for other in (FUSION, CAMERA)]


def discovery_server(machines):
    """Start a server beside fusion; return what both need to ask it."""
    binary = shutil.which('fast-discovery-server', path=os.path.dirname(sys.executable))
    machines[1].start('server', binary, '-i', '0', '-l', FUSION, '-p', str(PORT))
    return [{'ROS_DISCOVERY_SERVER': f'{FUSION}:{PORT}', 'ROS_SUPER_CLIENT': 'TRUE'}] * 2


def large_data(machines):
    """Return what each machine needs for images on the network, found by addresses."""
    return [each | {'FASTDDS_BUILTIN_TRANSPORTS': LARGE_DATA} for each in static_peers(machines)]


@pytest.mark.parametrize('recipe', [static_peers, discovery_server, large_data])
def test_what_a_camera_on_one_machine_sees_is_tracked_on_another(
    machines, recipe, walker_bag, projection
):
    camera, fusion = machines
    here, there = recipe(machines)
    # With the transport for large data the images cross the network, else detections do.
    sees = (fusion, there) if recipe is large_data else (camera, here)
    fusion.node('fusion_node', there, cameras=['cam1'])
    sees[0].node('camera_node', sees[1], **camera_parameters(projection, camera='cam1'))
    fusion.start(
        'echo', sys.executable, '-m', 'mctrack_ros.cli.main', 'echo', '/tracks', '--json', **there
    )
    awaited = ['/cam1/image_raw/compressed', '/cam1/detections 1', '/feedback 1', '/tracks 1']
    camera.node(
        'player', here, path=str(walker_bag), topics=['/cam1/.*'], wait_for=awaited, wait=100.0,
        restamp=True, loop=True,
    )  # fmt: skip
    end = time.monotonic() + PATIENCE_S
    while not re.search(r'"track_id": \[\d', (fusion.folder / 'echo.log').read_text()):
        logs = '\n'.join(path.read_text() for path in fusion.folder.glob('*.log'))
        assert time.monotonic() < end, logs
        time.sleep(0.2)
