"""The live map in headless Chromium: what its canvas shows of a graph and of a database."""

import colorsys
import json
import threading
from contextlib import ExitStack
from http.client import HTTPConnection
from urllib.parse import urlsplit

import numpy as np
import pytest

from mctrack_ros.interfaces import Detections, EventCode, Events, Tracks
from mctrack_ros.store import Database, NewRun, TrajectoryWriter
from mctrack_ros.tracking.colours import track_colour
from mctrack_ros.zones.files import read_zones
from ros_domains import free_domain
from web.conftest import free_port
from web.desk import PATIENCE_MS
from web.fields import write_site

PLACES = {1: (20.0, 20.0), 2: (80.0, 50.0), 300: (50.0, 34.0)}
BEGAN_S = 1_700_000_000
STATE = 'window.mctrackMap.state'
COLOUR = """(({px, py}) => [...document.querySelector('.stage canvas').getContext('2d')
  .getImageData(px * devicePixelRatio, py * devicePixelRatio, 1, 1).data].slice(0, 3))"""

pytestmark = [pytest.mark.browser, pytest.mark.live, pytest.mark.xdist_group('browser')]


class Graph:
    """Publishes what is true now, ten times a second."""

    def __init__(self, domain):
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.context import Context
        from rclpy.signals import SignalHandlerOptions
        from sensor_msgs.msg import CompressedImage, PointCloud2
        from std_msgs.msg import String

        from mctrack_ros.ros.topics.quality import latched, reliable

        self.context = Context()
        rclpy.init(
            context=self.context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.node = rclpy.create_node('graph', context=self.context)
        publisher = self.node.create_publisher
        self.tracks = publisher(PointCloud2, '/tracks', reliable(10))
        self.events = publisher(PointCloud2, '/events', reliable(100))
        self.health = publisher(DiagnosticArray, '/diagnostics', reliable(10))
        self.images = publisher(CompressedImage, '/cam1/image_raw/compressed', reliable(5))
        self.detections = publisher(PointCloud2, '/cam1/detections', reliable(5))
        self.site = publisher(String, '/site', latched())
        said = {'cameras': ['cam1', 'cam2'], 'zones': [{'name': 'door'}, {'name': 'gate'}]}
        self.site.publish(String(data=json.dumps(said)))
        self.places, self.is_healthy = dict(PLACES), True
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while not self.ended.wait(0.1):
            self.publish()

    def publish(self):
        from mctrack_ros.codec import cloud_from_rows, compressed_message, jpeg_from_image
        from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

        stamp_ns = self.node.get_clock().now().nanoseconds
        ids = list(self.places)
        tracks = Tracks.build(
            stamp_ns,
            position=[(*place, 0) for place in self.places.values()],
            covariance=np.tile(0.04 * np.eye(4), (len(ids), 1, 1)),
            track_id=ids,
            cameras=[{1: 1, 2: 2}.get(each, 0) for each in ids],
        )
        self.tracks.publish(cloud_from_rows(tracks, RCLPY_CLASSES, 'map'))
        if self.is_healthy:
            self.health.publish(self.diagnostics())
        if self.images.get_subscription_count():
            jpeg = jpeg_from_image(np.full((576, 768, 3), 90, np.uint8))
            message = compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, 'cam1')
            self.images.publish(message)
            found = Detections.build(
                stamp_ns, position=[(20, 20, 0)], box=[(100, 100, 200, 300)], track_id=[1]
            )
            self.detections.publish(cloud_from_rows(found, RCLPY_CLASSES, 'map'))

    def diagnostics(self):
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

        moved = DiagnosticStatus(
            level=b'\1', name='/cam1_camera: pose', hardware_id='/cam1', message='it has moved'
        )
        good = DiagnosticStatus(level=b'\0', name='/fusion: cam2', hardware_id='/cam2')
        return DiagnosticArray(status=[moved, good])

    def happen(self, track, code, zone=0):
        from mctrack_ros.codec import cloud_from_rows
        from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

        stamp_ns = self.node.get_clock().now().nanoseconds
        place = [(*self.places[track], 0)]
        events = Events.build(
            stamp_ns, position=place, track_id=[track], event=[code], zone=[zone]
        )
        self.events.publish(cloud_from_rows(events, RCLPY_CLASSES, 'map'))

    def close(self):
        self.ended.set()
        self.thread.join()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a site and a database that is being written: 20 s of id 7."""
    path = tmp_path_factory.mktemp('map')
    write_site(path)
    with Database(path / 'tracks.db', create=True) as database:
        writer = TrajectoryWriter(database, NewRun('run'), clock=lambda: 0.0)
        for k in range(200):
            stamp_ns = round((BEGAN_S + k / 10) * 1e9)
            rows = Tracks.build(stamp_ns, position=[(10 + k / 4, 40, 0)], track_id=[7])
            writer.write_tracks(rows)
        event = Events.build(stamp_ns, track_id=[7], event=[EventCode.MERGE])
        writer.write_events(event)
        writer.flush()
        yield path


class Map:
    """A page with the map of a graph; its server can be started again."""

    def __init__(self, graph, serve, folder, domain, page):
        self.graph, self.page = graph, page
        self._serve, self._folder, self._domain = serve, folder, str(domain)
        self._port, self._server = free_port(), ExitStack()
        self.start()
        page.goto(self.address)

    def start(self):
        options = ['--database', 'tracks.db', '--domain', self._domain]
        command = ('map', 'two.yaml', *options)
        served = self._serve(self._folder, *command, port=self._port)
        self.address = self._server.enter_context(served)

    def stop(self):
        self._server.close()

    @property
    def state(self):
        return self.page.evaluate(STATE)

    def until(self, condition):
        self.page.wait_for_function(
            f'() => {{ const s = window.mctrackMap && {STATE}; return s && {condition}; }}'
        )

    def pixel(self, x, y):
        """Return where a place is on the screen."""
        box = self.page.locator('.stage canvas').bounding_box()
        px, py = self.page.evaluate(f'([x, y]) => {STATE}.pixel(x, y)', [x, y])
        return box['x'] + px, box['y'] + py

    def click(self, x, y):
        self.page.mouse.click(*self.pixel(x, y))


@pytest.fixture(scope='module')
def shown(browser, serve, folder):
    with free_domain() as domain, ExitStack() as stack:
        graph = Graph(domain)
        stack.callback(graph.close)
        page = browser.new_page(viewport={'width': 1280, 'height': 800})
        page.set_default_timeout(PATIENCE_MS)
        errors = []
        page.on('pageerror', lambda error: errors.append(error))
        opened = Map(graph, serve, folder, domain, page)
        stack.callback(opened.stop)
        opened.until('s.tracks.length === 3')
        yield opened
        page.close()
        assert not errors


def test_everybody_is_drawn_at_his_place_in_his_colour(shown):
    tracks = {track['id']: track for track in shown.state['tracks']}
    assert {key: (each['x'], each['y']) for key, each in tracks.items()} == PLACES
    colours = json.dumps({key: list(track_colour(key)) for key in tracks})
    shown.until(f's.tracks.every(track => {COLOUR}(track) + "" === {colours}[track.id] + "")')
    assert tracks[1]['px'] < tracks[300]['px'] < tracks[2]['px']
    assert tracks[1]['py'] > tracks[300]['py'] > tracks[2]['py']
    shown.graph.places[1] = (25.0, 22.0)
    shown.until('s.tracks[0].x === 25 && s.tracks[0].y === 22')
    x, y = shown.pixel(60, 10)
    shown.page.mouse.move(x, y)
    before = shown.state['scale']
    shown.page.mouse.wheel(0, -200)
    shown.until(f's.scale > {before}')
    assert shown.pixel(60, 10) == pytest.approx((x, y), abs=0.5)
    shown.page.get_by_role('button', name='⤢').click()
    shown.until(f's.scale === {before}')


def test_events_are_listed_and_flash_as_they_happen(shown):
    shown.graph.happen(300, EventCode.SPLIT)
    shown.page.get_by_text('300: split').wait_for()
    shown.until('s.flashes === 1')
    shown.until('s.flashes === 0')
    shown.graph.happen(1, EventCode.CROSS_LEFT, zone=2)
    shown.page.get_by_text('1: crosses gate to its left').wait_for()


def test_cameras_are_shown_with_their_health_until_they_are_silent(shown):
    page = shown.page
    page.locator('.camera', has_text='cam1').get_by_text('pose: it has moved').wait_for()
    page.locator('.camera', has_text='cam2').get_by_text('good').wait_for()
    shown.graph.is_healthy = False
    page.locator('.camera', has_text='cam2').get_by_text('nothing heard for').wait_for()
    shown.graph.is_healthy = True


def test_the_images_of_a_camera_come_only_while_it_is_shown(shown):
    assert shown.graph.images.get_subscription_count() == 0
    button = shown.page.get_by_role('button', name='Show cam1')
    button.click()
    shown.until("s.pictures.includes('cam1')")
    grey, box = shown.page.evaluate(
        """() => { const canvas = document.querySelector('canvas[data-camera=cam1]');
        const at = (x, y) => [...canvas.getContext('2d').getImageData(
          x * canvas.width / 768, y * canvas.width / 768, 1, 1).data].slice(0, 3);
        return [at(600, 300), at(100, 250)]; }"""
    )
    assert grey == pytest.approx([90, 90, 90], abs=3)
    # the line is drawn between pixels: its hue is the track's
    hues = [colorsys.rgb_to_hsv(*colour)[0] for colour in (box, track_colour(1))]
    assert hues[0] == pytest.approx(hues[1], abs=0.06)
    button.click()
    for _ in range(100):
        if not shown.graph.images.get_subscription_count():
            return
        shown.page.wait_for_timeout(100)
    pytest.fail('the images are still subscribed to')


def test_who_is_followed_stays_in_the_middle_with_his_cameras_shown(shown):
    page = shown.page
    page.get_by_label('Find id').fill('2')
    page.get_by_label('Find id').press('Enter')
    shown.until('s.chosen === 2 && s.centre[0] === 80 && s.centre[1] === 50')
    shown.until("s.shown.length === 1 && s.shown[0] === 'cam2'")
    shown.graph.places[2] = (70.0, 45.0)
    shown.until('s.centre[0] === 70 && s.centre[1] === 45')
    page.get_by_role('button', name='Show cam2').click()
    page.get_by_role('button', name='Let go').click()
    page.get_by_role('button', name='⤢').click()
    shown.until('s.chosen === 0 && Math.abs(s.tracks[0].px - s.pixel(25, 22)[0]) < 1')
    shown.click(25, 22)
    shown.until('s.chosen === 1')
    page.get_by_role('button', name='Let go').click()


def test_the_past_is_dragged_to_and_left_again(shown):
    page, slider = shown.page, shown.page.get_by_label('Time')
    slider.fill(str(BEGAN_S + 10))
    shown.until("s.mode === 'past' && s.tracks.length === 1 && s.tracks[0].id === 7")
    (track,) = shown.state['tracks']
    assert (track['x'], track['y']) == pytest.approx((35, 40), abs=0.02)
    assert page.get_by_text('7: merge').count() == 0
    slider.fill(str(BEGAN_S + 20))
    page.get_by_text('7: merge').wait_for()
    shown.until('s.tracks.length === 1 && s.tracks[0].x === 59.75')
    page.get_by_role('button', name='live', exact=True).click()
    shown.until("s.mode === 'live' && s.tracks.length === 3")
    page.get_by_label('Find id').fill('7')
    page.get_by_label('Find id').press('Enter')
    page.get_by_text('7 was seen last at').wait_for()
    shown.until("s.mode === 'past' && s.chosen === 7 && s.tracks.length === 1")
    page.get_by_role('button', name='live', exact=True).click()
    page.get_by_role('button', name='Let go').click()


def test_zones_are_drawn_moved_named_deleted_and_saved(shown, folder):
    page = shown.page
    page.get_by_role('button', name='Zones', exact=True).click()
    for kind, corners in (
        ('zone', [(20, 40), (40, 40), (40, 60), (20, 60), (20, 40)]),
        ('zone', [(60, 10), (70, 10), (65, 20), (60, 10)]),
        ('line', [(50, 5), (50, 20), (50, 20)]),
    ):
        page.get_by_role('button', name=f'+ {kind}').click()
        for corner in corners:
            shown.click(*corner)
        shown.until(f's.zones.length && s.zones[s.zones.length - 1].kind === "{kind}"')
    shown.until('s.zones.length === 3')
    page.get_by_label('Name of zone').first.fill('by the gate')
    page.get_by_role('button', name='Delete zone 2').click()
    shown.click(30, 50)
    for start, end in (((30, 50), (32, 50)), ((42, 60), (45, 62))):
        page.mouse.move(*shown.pixel(*start))
        page.mouse.down()
        page.mouse.move(*shown.pixel(*end), steps=3)
        page.mouse.up()
    page.get_by_role('button', name='save').click()
    page.get_by_text('Saved 2 in').wait_for()
    zones = read_zones(folder / 'two.yaml')
    (zone,), (line,) = zones.zones, zones.lines
    assert (zone.name, line.name) == ('by the gate', 'line 1')
    wanted = [(22, 40), (42, 40), (45, 62), (22, 60)]
    np.testing.assert_allclose(zone.corners, wanted, atol=0.3)
    np.testing.assert_allclose(line.points, [(50, 5), (50, 20)], atol=0.3)
    page.get_by_label('Name of zone').fill('line 1')
    page.get_by_role('button', name='save').click()
    page.get_by_text('a line has the same name').wait_for()
    assert read_zones(folder / 'two.yaml') == zones
    page.get_by_role('button', name='discard').click()
    page.get_by_role('button', name='Events', exact=True).click()


def test_the_web_socket_needs_the_token(shown):
    address = urlsplit(shown.address)
    connection = HTTPConnection(address.hostname, address.port)
    upgrade = {'Connection': 'Upgrade', 'Upgrade': 'websocket'}
    key = {'Sec-WebSocket-Version': '13', 'Sec-WebSocket-Key': 'AAAAAAAAAAAAAAAAAAAAAA=='}
    connection.request('GET', f'/?{address.query}')
    answer = connection.getresponse()
    cookie = {'Cookie': answer.getheader('Set-Cookie').partition(';')[0]}
    connection.close()
    for headers, status in (({}, 403), (cookie, 101)):
        connection.request('GET', '/live', headers=upgrade | key | headers)
        assert connection.getresponse().status == status
        connection.close()


def test_a_window_is_live_again_after_the_server_was_away(shown):
    shown.stop()
    shown.until('!s.is_open')
    shown.start()
    shown.until('s.is_open && s.tracks.length === 3 && s.zones.length === 2')
    shown.graph.places[1] = (30.0, 30.0)
    shown.until('s.tracks.length === 3 && s.tracks[0].x === 30')
