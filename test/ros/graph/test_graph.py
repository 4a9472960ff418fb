"""A site's nodes live: players, cameras and fusion as processes of their own over DDS."""

import dataclasses
import json
import os
import signal
import subprocess
import sys
import threading
from dataclasses import replace

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import CompressedImage

from far_hall import write_far_hall
from mctrack_ros.codec import image_from_message, stamp_ns_of
from mctrack_ros.config import ConfigError, config_from
from mctrack_ros.interfaces import Detections, EventCode, Events, Ticks, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.ros.default_files import NODE_CONFIGS
from mctrack_ros.ros.graph.graph import (
    ENVIRONMENT,
    player_node,
    recorder_node,
    truth_of,
)
from mctrack_ros.ros.graph.site_graph import awaited_topics, site_nodes
from mctrack_ros.ros.graph.supervise import Supervisor
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.nodes.simulator_node import SimulatorNode
from mctrack_ros.site.site import load_site
from walker import PERIOD_NS, SIZE, walker_message

CAMERAS = ('cam1', 'cam2')
RECORDED = ['/tracks', '/feedback', '/events', '/ticks', '/cam./detections']


def written(folder, projection, names):
    """Return a site, in a file, of cameras that see the same walker from the same place."""
    camera = {'image_width': SIZE[0], 'image_height': SIZE[1], 'calibration': projection.name}
    content = {
        'cameras': {name: camera for name in names},
        'pipeline': {'background': {'learning_s': 0.2}},
    }
    path = folder / 'site.yaml'
    path.write_text(yaml.safe_dump(content))
    return load_site(path)


@pytest.fixture
def site(tmp_path, projection):
    """Return a site of two cameras."""
    return written(tmp_path, projection, CAMERAS)


@pytest.fixture
def lone_site(tmp_path, projection):
    """Return a site of one camera: its graph is started sooner."""
    return written(tmp_path, projection, CAMERAS[:1])


def test_every_node_of_a_far_site_is_told_the_same_origin(tmp_path):
    nodes = site_nodes(write_far_hall(tmp_path / 'far', (389010.0, 5820020.0)))
    told = {node.name: node.parameters for node in nodes}
    assert told['fusion']['origin'] == '389000,5820000'
    for name in ('north', 'south'):
        assert told[f'{name}_camera']['settings']['origin'] == '389000,5820000'


def patient_nodes(site, **options):
    """Return a site's nodes, with queues and waits that lose nothing on a busy machine."""
    batching = replace(site.fusion.batching, max_wait=50.0)
    site = replace(site, fusion=replace(site.fusion, batching=batching))
    return [
        node
        if node.name == 'fusion'
        else replace(node, parameters=node.parameters | {'depth': 100})
        for node in site_nodes(site, **options)
    ]


@pytest.fixture
def supervised(bench, tmp_path):
    """Return a function that runs nodes under a supervisor in a thread."""
    running = []

    def start(nodes):
        folder = tmp_path / 'parameters'
        folder.mkdir()
        lines = []
        supervisor = Supervisor([n.process(folder) for n in nodes], lines.append, ENVIRONMENT)
        thread = threading.Thread(target=supervisor.run)
        thread.start()
        running.append((supervisor, thread))
        return supervisor, thread, lines

    yield start
    for supervisor, thread in running:
        supervisor.stop()
        thread.join()


def test_a_site_becomes_a_node_a_camera_and_one_for_fusion(site, tmp_path):
    nodes = site_nodes(site, use_sim_time=True)
    assert [node.name for node in nodes] == ['fusion', 'cam1_camera', 'cam2_camera']
    for node in nodes:
        content = yaml.safe_load(node.write(tmp_path).read_text())
        values = content['/**']['ros__parameters']
        assert values.pop('use_sim_time') is True
        config_from(NODE_CONFIGS[node.executable], values)


@pytest.mark.parametrize('private', [True, False])
def test_all_nodes_of_a_private_site_know_that_it_is(site, private):
    nodes = site_nodes(dataclasses.replace(site, private=private, blur=False))
    assert {node.parameters['private'] for node in nodes} == {private}
    assert [node.parameters['blur'] for node in nodes[1:]] == [False, False]


@pytest.mark.parametrize(
    ('texts', 'meaning'),
    [
        (['true', 'True', 'TRUE', 'yes', 'Yes', 'on', '1', ' true '], True),
        (['false', 'False', 'FALSE', 'no', 'No', 'off', '0'], False),
    ],
)
def test_launch_arguments_are_true_or_false_as_yaml_and_launch_spell_it(texts, meaning):
    assert {truth_of('use_sim_time', text) for text in texts} == {meaning}


@pytest.mark.parametrize('text', ['', 'maybe', 'ture', '2', 'None', '[true]', '{'])
def test_what_is_neither_true_nor_false_is_refused(text):
    with pytest.raises(ConfigError, match=r'use_sim_time is .*, expected true or false'):
        truth_of('use_sim_time', text)


def test_own_detections_need_no_camera_nodes(site):
    assert [node.name for node in site_nodes(site, own_detections=True)] == ['fusion']


@pytest.mark.live
def test_a_parameter_file_that_is_given_goes_before_what_the_site_says(bench, site, tmp_path):
    own = tmp_path / 'own.yaml'
    own.write_text(yaml.safe_dump({'/**': {'ros__parameters': {'obstacle_height': 1.75}}}))
    written = site_nodes(site)[0].write(tmp_path)
    bench.open('--params-file', str(written), '--params-file', str(own))
    config = bench.add(FusionNode()).config
    assert (config.obstacle_height, config.cameras) == (1.75, CAMERAS)


@pytest.mark.live
def test_a_bag_is_tracked_live_and_recorded(bench, site, supervised, walker_bag, tmp_path):
    nodes = [
        *patient_nodes(site),
        recorder_node(tmp_path / 'out', RECORDED),
        player_node(walker_bag, restamp=True, wait_for=awaited_topics(site, True)),
    ]
    supervisor, thread, lines = supervised(nodes)
    thread.join(timeout=240)
    assert not thread.is_alive(), lines
    assert not supervisor.failures, '\n'.join(lines)
    with BagReader(tmp_path / 'out') as bag:
        counts = {topic: bag.count(topic) for topic in bag.topics}
        widths = [message.width for _, message, _ in bag.messages(['/tracks'])]
    assert counts['/cam1/detections'] == counts['/cam2/detections'] == 50, (counts, lines)
    assert counts['/ticks'] == 50, (counts, lines)
    assert max(widths) == 1


@pytest.mark.live
def test_people_who_explain_the_masks_are_tracked_live(site, supervised, walker_bag, tmp_path):
    path = tmp_path / 'occupancy.yaml'
    others = {
        'area': '-3,-2,4,2',
        'fusion': {'tracker': 'occupancy'},
        'zones': {'floor': {'corners': [[-9, -9], [9, -9], [9, 9], [-9, 9]]}},
    }
    path.write_text(yaml.safe_dump(yaml.safe_load((tmp_path / 'site.yaml').read_text()) | others))
    site = load_site(path)
    nodes = [
        *patient_nodes(site),
        recorder_node(tmp_path / 'out', [*RECORDED, '/cam./foreground/compressed', '/site']),
        player_node(walker_bag, restamp=True, wait_for=awaited_topics(site, True)),
    ]
    supervisor, thread, lines = supervised(nodes)
    thread.join(timeout=240)
    assert not thread.is_alive(), lines
    assert not supervisor.failures, '\n'.join(lines)
    with BagReader(tmp_path / 'out') as bag:
        assert bag.count('/cam1/foreground/compressed') == bag.count('/cam1/detections') == 50
        live = [rows for rows, _ in bag.rows('/tracks', Tracks)]
        ticks = recorded_ticks(bag, site.camera_names, site.fusion)
        options = {'views': site.views, 'zones': site.own_zones}
        outputs = [each.output for each in drive(site.fusion, site.camera_names, ticks, **options)]
        told = [rows for rows, _ in bag.rows('/events', Events)]
        (described,) = (message.data for _, message, _ in bag.messages(['/site']))
    again = [output.tracks for output in outputs]
    assert max(map(len, live)) >= 1
    assert [each['name'] for each in json.loads(described)['zones']] == ['floor']
    assert EventCode.ENTER_ZONE in np.concatenate([each.event for each in told])
    for one, other in zip(
        told, [each.events for each in outputs if len(each.events)], strict=True
    ):
        assert one.event.tolist() == other.event.tolist()
        assert one.zone.tolist() == other.zone.tolist()
        assert one.probability.tobytes() == other.probability.tobytes()
    for one, other in zip(live, again, strict=True):
        np.testing.assert_array_equal(one.position, other.position)
        np.testing.assert_array_equal(one.cameras, other.cameras)


@pytest.mark.live
def test_a_killed_camera_node_does_not_stop_fusion_and_comes_back(bench, site, supervised):
    supervisor, _, lines = supervised(site_nodes(site))
    bench.open()
    ticks, tracks = bench.rows(Ticks, '/ticks'), bench.rows(Tracks, '/tracks')
    returned = bench.rows(Detections, '/cam2/detections')
    images = [
        bench.publisher(CompressedImage, f'/{camera}/image_raw/compressed') for camera in CAMERAS
    ]
    shown = [0]

    def show():
        for camera, publisher in zip(CAMERAS, images):
            publisher.publish(walker_message(shown[0], now_ns(bench), camera))
        shown[0] += 1

    bench.observer.create_timer(PERIOD_NS * 1e-9, show)
    bench.until(lambda: tracks and len(tracks[-1]) == 1)
    os.kill(supervisor.pids()['cam2_camera'], signal.SIGKILL)
    del ticks[:], tracks[:], returned[:]
    bench.until(lambda: any(tick.alive.tolist() == [1, 0] for tick in ticks))
    seen_before = len(tracks)
    bench.until(lambda: sum(len(one) > 0 for one in tracks[seen_before:]) >= 5)
    bench.until(lambda: ticks[-1].alive.tolist() == [1, 1] and returned)
    assert supervisor.starts() == {'fusion': 1, 'cam1_camera': 1, 'cam2_camera': 2}, lines


def now_ns(bench):
    return bench.observer.get_clock().now().nanoseconds


@pytest.mark.live
def test_nodes_on_simulated_time_track_a_bag(bench, lone_site, supervised, walker_bag, tmp_path):
    nodes = [
        *patient_nodes(lone_site, use_sim_time=True),
        recorder_node(tmp_path / 'out', RECORDED, use_sim_time=True),
        player_node(walker_bag, wait_for=awaited_topics(lone_site, True)),
    ]
    _, thread, lines = supervised(nodes)
    thread.join(timeout=240)
    assert not thread.is_alive(), lines
    with BagReader(tmp_path / 'out') as bag:
        times = [time_ns for _, _, time_ns in bag.messages(['/tracks'])]
    start_ns = 1_700_000_000 * 10**9
    assert all(start_ns <= time_ns <= start_ns + 3 * 10**9 for time_ns in times)
    assert len(times) >= 45


@pytest.mark.live
def test_simulator_shows_the_car_park_too(bench):
    bench.open(
        *('-p', 'scene:=carpark', '-p', 'cameras:=[cam1]', '-p', 'rate:=4.0'),
        *('-p', 'duration:=20.0'),
    )
    images = bench.messages(CompressedImage, '/cam1/image_raw/compressed')
    seen = bench.rows(Detections, '/truth/cam1/detections')
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    bench.add(SimulatorNode())
    bench.until(lambda: len(images) >= 3 and seen and reports)
    assert reports[0].status[0].name == '/simulator_node: images'
    assert image_from_message(images[0]).shape == (480, 640, 3)
    stamps = np.diff([stamp_ns_of(image) for image in images])
    assert (stamps % 250_000_000 == 0).all()


@pytest.mark.live
def test_simulator_shows_images_and_truth_of_the_same_instant(bench):
    bench.open('-p', 'cameras:=[cam2]', '-p', 'duration:=5.0', '-p', 'rate:=10.0')
    images = bench.messages(CompressedImage, '/cam2/image_raw/compressed')
    people = bench.rows(Tracks, '/truth/tracks')
    seen = bench.rows(Detections, '/truth/cam2/detections')
    happened = bench.rows(Events, '/truth/cam2/events')
    bench.add(SimulatorNode())
    bench.until(lambda: len(images) >= 3 and people and seen and happened)
    stamps = [stamp_ns_of(image) for image in images]
    assert stamps == sorted(stamps)
    assert people[-1].stamp_ns % 100_000_000 == 50_000_000
    assert people[0].stamp_ns in stamps
    assert len(people[0]) == 25
    assert happened[0].stamp_ns in {rows.stamp_ns for rows in people}
    assert EventCode.ENTER in happened[0].event or EventCode.NEW in happened[0].event
    assert set(happened[0].track_id) <= set(people[0].track_id)
    assert abs(stamps[-1] - now_ns(bench)) < 5 * 10**9


@pytest.mark.live
def test_a_graph_runs_in_a_namespace_and_leaves_nothing_when_its_terminal_closes(
    bench, lone_site, tmp_path
):
    folder = tmp_path / 'temporary'
    folder.mkdir()
    command = [sys.executable, '-m', 'mctrack_ros.cli.main', 'run', str(tmp_path / 'site.yaml')]
    bench.open()
    with subprocess.Popen(
        [*command, '--namespace', 'hall'],
        env=os.environ | {'TMPDIR': str(folder)},
        stdout=subprocess.PIPE,
        text=True,
    ) as graph:
        bench.until(lambda: bench.observer.count_publishers('/hall/tracks') == 1, patience_s=60)
        assert list(folder.glob('mctrack_*'))
        graph.send_signal(signal.SIGHUP)
        said, _ = graph.communicate(timeout=200)
    assert graph.returncode == 0, said
    assert not list(folder.glob('mctrack_*'))
