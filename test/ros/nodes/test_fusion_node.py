"""The fusion node over DDS: what it publishes, and what cannot stop it."""

import copy
import itertools
import json
import re
import signal
import time

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseArray, PoseStamped
from rcl_interfaces.msg import Log
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import (
    Candidates,
    Decisions,
    Detections,
    EventCode,
    Events,
    Feedback,
    Reason,
    Ticks,
    Tracks,
)
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched, reliable

pytestmark = pytest.mark.live

PERIOD_NS = 40_000_000
CAMERAS = ['cam1', 'cam2']
UNTIMED = {'batching': {'time_sync_limit': 0.0}}
"""The stamps are of no clock, so on a busy machine arrivals would tell of a wrong one."""
COMPARED = {'batching': {'time_sync_limit': 0.2}}
"""As by default."""


def seen(index, count=1):
    """Return detections of people who stand still."""
    if not count:
        return Detections.build(index * PERIOD_NS + PERIOD_NS // 2)
    return Detections.build(
        index * PERIOD_NS + PERIOD_NS // 2,
        position=[[10.0 * person, 5.0, 0.0] for person in range(count)],
        covariance=np.tile(np.eye(2) * 0.04, (count, 1, 1)),
        box=np.tile([10.0, 10.0, 20.0, 50.0], (count, 1)),
    )


def cloud(rows):
    return cloud_from_rows(rows, RCLPY_CLASSES, 'map')


class Cameras:
    """What two camera nodes would publish, and what the fusion node makes of it."""

    def __init__(self, bench, prefix=''):
        self.bench = bench
        self.tracks = bench.rows(Tracks, f'{prefix}/tracks')
        self.ticks = bench.rows(Ticks, f'{prefix}/ticks')
        self.feedback = bench.rows(Feedback, f'{prefix}/feedback')
        self.detections = {
            camera: bench.publisher(PointCloud2, f'{prefix}/{camera}/detections')
            for camera in CAMERAS
        }
        for topic in ('tracks', 'ticks', 'feedback'):
            bench.heard(f'{prefix}/{topic}')

    def send(self, camera, index, count=1):
        self.detections[camera].publish(cloud(seen(index, count)))

    def connect(self, index, count=0):
        """Send images of nobody, from one on, until another process answers; return the next."""
        indices = itertools.count(index)

        def send():
            image = cloud(seen(next(indices), count))
            for publisher in self.detections.values():
                publisher.publish(image)

        self.bench.answer(send, self.ticks)
        return next(indices)

    def both(self, indices, count=1):
        """Send both cameras' detections tick by tick, each fused before the next."""
        told = self.detections.values()
        self.bench.until(lambda: all(one.get_subscription_count() for one in told))
        for index in indices:
            before = len(self.ticks)
            for camera in CAMERAS:
                self.send(camera, index, count)
            self.bench.until(lambda before=before: len(self.ticks) > before)


def open_fusion(bench, fusion=UNTIMED, **parameters):
    bench.make(FusionNode, cameras=CAMERAS, fusion=fusion, **parameters)
    return Cameras(bench)


def test_people_become_tracks_that_are_fed_back(bench):
    graph = open_fusion(bench)
    graph.both(range(100, 130))
    bench.until(lambda: len(graph.feedback) == 30 and len(graph.tracks) == 30)
    assert len(graph.tracks[-1]) == 1
    assert graph.tracks[-1].stamp_ns == seen(129).stamp_ns
    assert graph.feedback[-1].track_id.tolist() == graph.tracks[-1].track_id.tolist()


def test_a_misspelt_field_is_left_out_and_said_once(bench):
    graph = open_fusion(bench)
    heard = bench.messages(Log, '/rosout', reliable(100))
    bench.until(lambda: bench.observer.count_publishers('/rosout') > 1)
    for index in (100, 101):
        message = copy.deepcopy(cloud(seen(index)))
        message.fields[-1].name = 'clas_id'
        graph.detections['cam1'].publish(message)
    health, last_ns = bench.nodes[0].health['cam1'], seen(101).stamp_ns
    bench.until(lambda: health.last_stamp_ns == last_ns)
    bench.until(lambda: any('clas_id' in each.msg for each in heard))
    said = [each.msg for each in heard if 'clas_id' in each.msg]
    assert said == ['cam1/detections: fields that are not known are left out: clas_id']


def test_late_data_are_dropped_and_counted(bench):
    graph = open_fusion(bench)
    graph.both(range(100, 105))
    graph.send('cam1', 102, count=3)
    bench.until(lambda: bench.nodes[0].health['cam1'].received >= 6)
    graph.both([105])
    assert graph.ticks[-1].late.tolist() == [1, 0]
    assert graph.ticks[-1].dropped_detections.tolist() == [3, 0]
    assert [tick.stamp_ns // PERIOD_NS for tick in graph.ticks] == list(range(100, 106))


def test_out_of_order_data_of_open_ticks_are_fused_in_order(bench):
    graph = open_fusion(bench, fusion={'batching': {'max_wait': 50.0, 'time_sync_limit': 0.0}})
    graph.both([100])
    for camera, index in (('cam2', 102), ('cam1', 102), ('cam1', 101), ('cam2', 101)):
        graph.send(camera, index)
    bench.until(lambda: len(graph.ticks) >= 2)
    graph.both([103])
    indices = [tick.stamp_ns // PERIOD_NS for tick in graph.ticks]
    assert indices == sorted(indices)


def test_a_silent_camera_does_not_stop_fusion(bench):
    graph = open_fusion(bench)
    graph.both(range(100, 103))
    for index in range(103, 108):
        graph.send('cam1', index)
        bench.until(lambda index=index: graph.ticks[-1].stamp_ns // PERIOD_NS == index)
    assert graph.ticks[-1].missing.tolist() == [0, 1]


def test_missed_feedback_is_on_ticks(bench):
    graph = open_fusion(bench)
    events = bench.publisher(PointCloud2, '/cam2/events')
    missed = Events.build(0, event=[EventCode.FEEDBACK_MISSED, EventCode.FEEDBACK_MISSED])
    events.publish(cloud(missed))
    bench.until(lambda: bench.nodes[0].health['cam2'].totals.get('feedback missed') == 2)
    graph.both([100])
    assert graph.ticks[-1].feedback_missed.tolist() == [0, 2]


def broken_clouds():
    lacking = cloud(seen(101))
    lacking.fields = [field for field in lacking.fields if field.name != 'score']
    cut = cloud(seen(101))
    cut.data = cut.data[:-8]
    wrong = copy.deepcopy(cloud(seen(101)))
    wrong.fields[3].datatype = 2
    infinite = cloud(
        Detections.build(0, position=[[np.inf, 0, 0]], covariance=[np.eye(2)], box=[[0, 0, 1, 1]])
    )
    return {'lacking': lacking, 'cut': cut, 'wrong': wrong, 'not finite': infinite}


def test_broken_clouds_are_refused_and_the_node_lives_on(bench):
    graph = open_fusion(bench)
    graph.both([100])
    for message in broken_clouds().values():
        graph.detections['cam1'].publish(message)
    health = bench.nodes[0].health['cam1']
    bench.until(lambda: health.totals.get('refused') == len(broken_clouds()))
    graph.both([101])
    assert graph.ticks[-1].admitted.tolist() == [1, 1]


def test_site_is_latched_and_decodes_the_bits(bench):
    open_fusion(bench)
    sites = bench.messages(String, '/site', latched())
    bench.until(lambda: sites)
    site = json.loads(sites[0].data)
    assert site['cameras'] == CAMERAS
    assert site['codes']['EventCode']['FEEDBACK_MISSED'] == EventCode.FEEDBACK_MISSED
    assert len(site['configuration_hash']) == 64


def test_site_says_what_positions_are_told_from(bench):
    bench.make(FusionNode, cameras=CAMERAS, origin='389000,5820000')
    sites = bench.messages(String, '/site', latched())
    bench.until(lambda: sites)
    assert json.loads(sites[0].data)['origin'] == [389000.0, 5820000.0]


def test_what_is_no_origin_ends_it_with_its_reason(refusal):
    line = refusal('fusion_node', origin='389000')[-1]
    assert 'expected x,y in metres, for example 389000,5820000' in line


def ids_of(graph, indices):
    """Return the ids of the tracks of people whom both cameras see for some ticks."""
    before = len(graph.tracks)
    graph.both(indices)
    graph.bench.until(lambda: len(graph.tracks) >= before + len(indices))
    return {int(name) for rows in graph.tracks[before:] for name in rows.track_id}


def test_a_node_configured_again_deals_out_ids_above_the_old_ones_and_says_that_it_is_a_new_run(
    bench,
):
    graph = open_fusion(bench)
    sites = bench.messages(String, '/site', latched())
    bench.until(lambda: sites)  # its publisher ends with the first run
    first = ids_of(graph, range(100, 115))
    node = bench.nodes[0]
    for transition in ('deactivate', 'cleanup', 'configure', 'activate'):
        getattr(node, f'trigger_{transition}')()
    begin = graph.connect(200)
    second = ids_of(graph, range(begin, begin + 15))
    assert first == {1}
    assert second == {2}
    bench.until(lambda: len(sites) == 2)
    assert len({json.loads(site.data)['run'] for site in sites}) == 2


def test_a_killed_node_that_starts_again_uses_no_id_twice(bench):
    bench.open()
    used = []
    for life in range(2):
        process = bench.spawn('fusion_node', cameras=CAMERAS, fusion=UNTIMED, resume=0.0)
        graph = Cameras(bench)
        first = graph.connect(100 * (life + 1))
        used.append(ids_of(graph, range(first, first + 15)))
        process.send_signal(signal.SIGKILL)
        process.wait()
        bench.until(lambda: bench.observer.count_publishers('/tracks') == 0)
    assert used[0] == {1}
    assert used[1]
    assert min(used[1]) > 1


def test_a_killed_node_goes_on_with_its_tracks_and_says_how_long_it_was_blind(bench, tmp_path):
    bench.open()
    site = tmp_path / 'site.yaml'
    corners = [[-5, 0], [5, 0], [5, 9], [-5, 9]]
    site.write_text(yaml.safe_dump({'zones': {'hall': {'corners': corners}}}))
    told_of = bench.rows(Events, '/events')
    sites = bench.messages(String, '/site', latched())
    reports = bench.messages(DiagnosticArray, '/diagnostics')

    def told():
        return [one for each in reports for one in each.status if one.name.endswith(': restart')]

    used = []
    for life in range(2):
        process = bench.spawn(
            'fusion_node', cameras=CAMERAS, fusion=UNTIMED, resume=300.0, site=str(site)
        )
        graph = Cameras(bench)
        index = 100 * (life + 1)
        for _ in range(20):
            index = graph.connect(index, count=1)
        used.append({int(name) for rows in graph.tracks for name in rows.track_id})
        bench.until(lambda life=life: told() and (told()[-1].level != b'\0') == life)
        bench.until(lambda life=life: len(sites) > life)
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert used == [{1}, {1}]
    entered = [rows.event == EventCode.ENTER_ZONE for rows in told_of]
    assert sum(each.sum() for each in entered) == 1  # it knows who was in the zone, too
    assert re.match(r'was blind for \d+\.\d\d s: 1 tracks went on', told()[-1].message)
    assert told()[-1].level == DiagnosticStatus.WARN
    assert told()[-1].message in bench.log('fusion_node')
    first, second = (json.loads(site.data) for site in (sites[0], sites[-1]))
    assert first['run'] == second['run']
    assert second['state']


def test_thresholds_change_at_run_time_and_the_rest_is_refused_with_what_to_do(bench):
    graph = open_fusion(bench)
    sites = bench.messages(String, '/site', latched())
    bench.until(lambda: sites)  # what is said next replaces it
    index = 100
    for _ in range(20):
        index = graph.connect(index, count=1)
    node = bench.nodes[0]
    changes = [Parameter('fusion.management.most_tracks', value=1)]
    assert node.set_parameters(changes)[0].successful
    told = [Parameter('fusion.batching.period', value=0.1)]
    reason = node.set_parameters(told)[0].reason
    assert 'ros2 lifecycle set /fusion_node deactivate, then cleanup' in reason
    for _ in range(20):
        index = graph.connect(index, count=2)
    bench.until(lambda: len(graph.tracks) >= 40)
    assert {int(name) for rows in graph.tracks for name in rows.track_id} == {1}
    bench.until(lambda: len(sites) == 2)
    first, second = (json.loads(site.data) for site in sites)
    assert first['run'] == second['run']
    assert second['fusion']['management']['most_tracks'] == 1


def test_ids_begin_at_one_each_time_if_no_file_keeps_them(bench):
    graph = open_fusion(bench, state_file='')
    assert ids_of(graph, range(100, 115)) == {1}
    node = bench.nodes[0]
    for transition in ('deactivate', 'cleanup', 'configure'):
        getattr(node, f'trigger_{transition}')()
    assert node.tracker.next_id == 1
    assert not (bench.folder / 'ros_home' / 'mctrack_ros').exists()


def test_ids_that_cannot_be_kept_are_an_error_in_the_diagnostics_and_tracking_goes_on(bench):
    state = bench.folder / 'state' / 'ids.json'
    graph = open_fusion(bench, state_file=str(state))
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    bench.nodes[0].tracker._manager.next_id = 900
    state.with_name('ids.json.new').mkdir()
    assert ids_of(graph, range(100, 115)) == {900}
    bench.until(lambda: reports and reports[-1].status[-4].level == DiagnosticStatus.ERROR)
    assert 'ids may be used again' in reports[-1].status[-4].message
    state.with_name('ids.json.new').rmdir()
    graph.both([115])
    assert json.loads(state.read_text())['next_id'] > 901


def test_diagnostics_report_each_camera(bench):
    graph = open_fusion(bench, fusion=COMPARED)
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    index = 100
    while not (reports and reports[-1].status[0].message == 'receiving'):
        graph.both([index])  # who has been silent for long when the second ends is not receiving
        index += 1
    assert [(status.name, status.hardware_id) for status in reports[-1].status] == [
        ('/fusion_node: cam1', '/cam1'),
        ('/fusion_node: cam2', '/cam2'),
        ('/fusion_node: cam1 clock', '/cam1'),
        ('/fusion_node: cam2 clock', '/cam2'),
        ('/fusion_node: clocks', '/fusion_node'),
        ('/fusion_node: ids', '/fusion_node'),
        ('/fusion_node: restart', '/fusion_node'),
        ('/fusion_node: tracking', '/fusion_node'),
        ('/fusion_node: exceptions', '/fusion_node'),
    ]
    assert reports[-1].status[2].message == 'its clock agrees with those of the other cameras'


def test_a_camera_whose_clock_is_an_hour_ahead_is_named_and_the_other_goes_on(bench):
    graph = open_fusion(bench, fusion=COMPARED)
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    shift_ns = time.time_ns() - 100 * PERIOD_NS
    for index in range(100, 125):
        for camera, ahead_ns in (('cam2', 3600 * 10**9), ('cam1', 0)):
            rows = seen(index)
            graph.detections[camera].publish(cloud(rows.at(rows.stamp_ns + shift_ns + ahead_ns)))
        bench.until(lambda index=index: len(graph.ticks) > index - 100)
    bench.until(lambda: reports and 'left out' in reports[-1].status[3].message)
    assert 'its stamps lie 3600.0' in reports[-1].status[3].message
    assert sum(int(tick.left_out[1]) for tick in graph.ticks) >= 20
    assert graph.ticks[-1].admitted.tolist() == [1, 0]
    assert abs(graph.tracks[-1].stamp_ns - time.time_ns()) < 600 * 10**9


def test_clocks_that_jump_together_are_one_warning(bench, capfd):
    graph = open_fusion(bench, fusion=COMPARED)
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    began_ns = time.time_ns()
    for index in range(75):
        stamp_ns = began_ns + index * PERIOD_NS
        bench.until(lambda due_ns=stamp_ns: time.time_ns() > due_ns)
        for camera in CAMERAS:
            rows = seen(index).at(stamp_ns + 3600 * 10**9 * (index >= 25))
            graph.detections[camera].publish(cloud(rows))
    bench.until(lambda: any('jumped' in status.message for status in reports[-1].status))
    said = [status.message for each in reports for status in each.status]
    jumped = re.compile(r"all cameras' stamps jumped ahead by (3600\.0|3599\.9)")
    assert any(map(jumped.match, said))
    assert not [each for each in said if 'left out' in each or 'removed' in each]
    assert graph.ticks[-1].admitted.all()
    log = capfd.readouterr().err
    assert len(jumped.findall(log)) == 1
    assert 'left out' not in log


def test_what_people_look_at_is_published_while_they_look(bench):
    graph = open_fusion(bench)
    markers = bench.messages(MarkerArray, '/tracks/markers')
    poses = bench.messages(PoseArray, '/tracks/poses')
    obstacles = bench.messages(PointCloud2, '/tracks/obstacles')
    for topic in ('markers', 'poses', 'obstacles'):
        bench.heard(f'/tracks/{topic}')
    graph.both(range(100, 130))
    bench.until(lambda: markers and markers[-1].markers and poses[-1].poses)
    bench.until(lambda: obstacles and obstacles[-1].width)
    assert {marker.ns for marker in markers[-1].markers} >= {'body', 'name', 'covariance'}
    assert poses[-1].header.frame_id == 'map'


def test_whom_to_follow_is_chosen_at_run_time(bench):
    graph = open_fusion(bench)
    poses = bench.messages(PoseStamped, '/followed')
    bench.heard('/followed')
    ids = ids_of(graph, range(100, 115))
    node = bench.nodes[0]
    (result,) = node.set_parameters([Parameter('follow', value=min(ids))])
    assert result.successful
    graph.both(range(115, 120))
    bench.until(lambda: poses)
    (result,) = node.set_parameters([Parameter('ground_frame', value='hall')])
    assert not result.successful


def test_a_service_follows_one_person_after_another_and_the_parameter_says_whom(bench):
    graph = open_fusion(bench)
    node = bench.nodes[0]
    client = bench.observer.create_client(Trigger, '/fusion_node/follow_next')
    bench.until(client.service_is_ready)

    def ask():
        answer = client.call_async(Trigger.Request())
        bench.until(answer.done)
        return answer.result().success, answer.result().message

    nobody = []
    bench.answer(
        lambda: client.call_async(Trigger.Request()).add_done_callback(nobody.append), nobody
    )
    assert nobody[0].result().message == 'nobody is tracked'
    assert not nobody[0].result().success
    assert node.get_parameter('follow').value == 0
    first = graph.connect(100)
    graph.both(range(first, first + 30), count=3)
    bench.until(lambda: graph.tracks[-1].stamp_ns == seen(first + 29).stamp_ns)
    ids = sorted(graph.tracks[-1].track_id.tolist())
    assert len(ids) == 3
    for track_id in (*ids, ids[0]):
        assert ask() == (True, str(track_id))
        assert node.get_parameter('follow').value == track_id
    node.followed.track_id = ids[1]  # as a correction does
    graph.both([first + 30], count=3)
    bench.until(lambda: node.get_parameter('follow').value == ids[1])


def test_namespace_and_remapping_move_its_topics(bench):
    path = bench.parameter_file('fusion', {'cameras': CAMERAS})
    bench.open(
        '-r', '__ns:=/hall', '-r', 'tracks:=people', '-r', '__node:=server', '--params-file',
        str(path),
    )  # fmt: skip
    node = bench.add(FusionNode())
    tracks = bench.rows(Tracks, '/hall/people')
    detections = bench.publisher(PointCloud2, '/hall/cam1/detections')
    bench.heard('/hall/people')
    detections.publish(cloud(seen(100)))
    bench.until(lambda: tracks)
    assert node.get_fully_qualified_name() == '/hall/server'
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    bench.until(lambda: reports)
    assert [(status.name, status.hardware_id) for status in reports[-1].status] == [
        ('/hall/server: cam1', '/hall/cam1'),
        ('/hall/server: cam2', '/hall/cam2'),
        ('/hall/server: cam1 clock', '/hall/cam1'),
        ('/hall/server: cam2 clock', '/hall/cam2'),
        ('/hall/server: clocks', '/hall/server'),
        ('/hall/server: ids', '/hall/server'),
        ('/hall/server: restart', '/hall/server'),
        ('/hall/server: tracking', '/hall/server'),
        ('/hall/server: exceptions', '/hall/server'),
    ]


def test_a_start_that_fails_says_why_and_nothing_else(bench, capfd):
    class Unheard(FusionNode):
        def subscribe(self, *arguments):
            raise OSError('nothing can be heard')

    path = bench.parameter_file('fusion', {'cameras': CAMERAS, 'autostart': False})
    bench.open('--params-file', str(path))
    node = bench.add(Unheard())
    node.trigger_configure()
    node.trigger_activate()
    assert node.failure == 'nothing can be heard'
    assert 'Traceback' not in capfd.readouterr().err


def test_why_is_told_while_somebody_asks(bench):
    graph = open_fusion(bench)
    graph.both(range(100, 110))
    candidates = bench.rows(Candidates, '/explanation/candidates')
    decisions = bench.rows(Decisions, '/explanation/decisions')
    for topic in ('candidates', 'decisions'):
        bench.heard(f'/explanation/{topic}')
    bench.until(bench.nodes[0].is_asked_why)
    graph.both(range(110, 120))
    bench.until(lambda: len(candidates) == len(decisions) == 10)
    assert candidates[-1].stamp_ns == decisions[-1].stamp_ns == seen(119).stamp_ns
    assert candidates[-1].track_id.tolist() == [1, 1]
    assert decisions[-1].reason.tolist() == [Reason.SEEN]
