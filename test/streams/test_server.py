import contextlib
import gzip
import json
import socket
import threading
import time

import httpx
import pytest
from lxml import etree
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect as web_socket

from mctrack_ros.store.errors import StoreError
from mctrack_ros.streams.serve import connections
from mctrack_ros.streams.serve import hub as hub_module
from mctrack_ros.streams.serve.hub import MOST_WAITING
from mctrack_ros.streams.serve.packing import KEY_FRAMES
from stream_story import ABOUT, frames_of, stamp_ns, tracks

PATIENCE_S = 30.0
TOKEN = 'for-the-stream-test'


def until(condition):
    """Wait until a condition holds, or fail."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, 'what was waited for did not happen'
        time.sleep(0.005)


def walk(first, last, people=3):
    """Return frames of some who walk."""
    return frames_of((tracks(n, list(range(1, people + 1))), None) for n in range(first, last))


def address(server, name='', scheme='http'):
    return f'{scheme}://127.0.0.1:{server.port}/{name}'


class Listener(threading.Thread):
    """One who reads a stream to its end."""

    def __init__(self, server, name, **headers):
        super().__init__(daemon=True)
        self.address, self.headers, self.body = address(server, name), headers, b''
        self.start()

    def run(self):
        with httpx.stream('GET', self.address, headers=self.headers, timeout=PATIENCE_S) as answer:
            self.answer = answer
            for part in answer.iter_bytes():
                self.body += part

    def text(self):
        self.join(PATIENCE_S)
        return self.body.decode()


def end(hub, server):
    server.loop.call_soon_threadsafe(hub.end)


def stamps(text):
    return [int(each.get('stamp_ns')) for each in etree.fromstring(text.encode())]


@pytest.mark.parametrize('coding', ['gzip', 'identity'])
def test_a_reader_reads_all_from_where_it_says_on(serve, coding):
    hub, server = serve()
    past, live = walk(0, 70), walk(70, 70 + 2 * KEY_FRAMES)
    for frame in past:
        hub.publish(frame)
    headers = {'accept-encoding': coding}
    listener = Listener(server, f'tracks.xml?since={stamp_ns(9)}', **headers)
    until(lambda: hub.count == 1 and f'"{stamp_ns(69)}"'.encode() in listener.body)
    for frame in live:
        hub.publish(frame)
        time.sleep(0.001)
    until(lambda: f'"{live[-1].stamp_ns}"'.encode() in listener.body)
    end(hub, server)
    assert stamps(listener.text()) == [stamp_ns(n) for n in range(10, 70 + 2 * KEY_FRAMES)]
    assert listener.answer.headers.get('content-encoding') == {'gzip': 'gzip'}.get(coding)
    until(lambda: hub.count == 0)


def test_without_a_time_a_reader_reads_what_comes(serve):
    hub, server = serve()
    hub.publish(walk(0, 1)[0])
    listener = Listener(server, 'tracks.json')
    until(lambda: hub.count == 1 and listener.body)
    for frame in walk(1, 4):
        hub.publish(frame)
    until(lambda: listener.body.count(b'\n') == 4)
    end(hub, server)
    head, *lines = map(json.loads, listener.text().splitlines())
    assert head == {
        'version': 1,
        'run': ABOUT.run,
        'frame_id': 'map',
        'origin': [389000.0, 5820000.0],
    }
    assert [line['stamp_ns'] for line in lines] == [stamp_ns(n) for n in (1, 2, 3)]


def test_the_memory_is_bounded(serve):
    hub, server = serve(memory_s=1.0)
    for frame in walk(0, 100):
        hub.publish(frame)
    listener = Listener(server, 'tracks.xml?since=0')
    until(lambda: f'"{stamp_ns(99)}"'.encode() in listener.body)
    end(hub, server)
    assert stamps(listener.text()) == [stamp_ns(n) for n in range(74, 100)]


def test_another_run_ends_the_streams(serve):
    hub, server = serve()
    listener = Listener(server, 'onvif.xml')
    until(lambda: hub.count == 1 and listener.body)
    hub.describe(type(ABOUT)('another', 'map'))
    etree.fromstring(listener.text().encode())


class Kept:
    """What is older, in a list."""

    def __init__(self, frames):
        self.frames, self.asked = frames, []

    def __call__(self, about, after_ns):
        assert about == ABOUT
        return self

    def next(self, after_ns, before_ns):
        self.asked.append((after_ns, before_ns))
        found = [each for each in self.frames if after_ns < each.stamp_ns < before_ns]
        return found[:10]


def test_what_is_older_comes_from_the_database(serve):
    kept = Kept(walk(0, 60))
    hub, server = serve(kept)
    for frame in walk(50, 55):
        hub.publish(frame)
    listener = Listener(server, f'tracks.xml?since={stamp_ns(4)}')
    until(lambda: f'"{stamp_ns(54)}"'.encode() in listener.body)
    end(hub, server)
    assert stamps(listener.text()) == [stamp_ns(n) for n in range(5, 55)]
    assert all(before_ns == stamp_ns(50) for _, before_ns in kept.asked)


def test_a_database_that_is_away_does_not_end_a_stream(serve):
    class Away(Kept):
        def next(self, after_ns, before_ns):
            raise StoreError('the database is away')

    hub, server = serve(Away([]))
    hub.publish(walk(7, 8)[0])
    listener = Listener(server, 'tracks.xml?since=5')
    until(lambda: f'"{stamp_ns(7)}"'.encode() in listener.body)
    assert hub.trouble == 'the database is away'


@pytest.mark.parametrize('name', ['tracks.xml', 'tracks.json', 'onvif.xml'])
def test_a_web_socket_sends_a_message_a_frame(serve, frames, name):
    hub, server = serve()
    hub.publish(frames[0])
    with web_socket(address(server, f'{name}?since=0', 'ws')) as opened:
        messages = [opened.recv(PATIENCE_S)]
        until(lambda: hub.count == 1)
        for frame in frames[1:]:
            hub.publish(frame)
        wanted = len(frames) + (name == 'tracks.json')
        messages += [opened.recv(PATIENCE_S) for _ in range(wanted - 1)]
        assert 'permessage-deflate' in opened.response.headers['Sec-WebSocket-Extensions']
        end(hub, server)
        with pytest.raises(ConnectionClosed):
            opened.recv(PATIENCE_S)
    profile = hub.profiles[name]
    expected = [profile.message(profile.head(ABOUT), profile.frame(each)) for each in frames]
    assert messages[-len(frames) :] == expected
    if profile.wraps:
        for message in messages:
            etree.fromstring(message.encode())


def test_who_talks_to_a_web_socket_is_cut_off(serve):
    hub, server = serve()
    with web_socket(address(server, 'tracks.json', 'ws')) as opened:
        opened.recv(PATIENCE_S)
        opened.send('hello')
        with pytest.raises(ConnectionClosed):
            opened.recv(PATIENCE_S)
    until(lambda: hub.count == 0)


def status(server, name='tracks.xml', method='GET', body=None, **headers):
    with httpx.stream(method, address(server, name), content=body, headers=headers) as answer:
        return answer.status_code


def socket_status(server, **headers):
    try:
        with web_socket(address(server, 'tracks.xml', 'ws'), additional_headers=headers):
            return 101
    except InvalidStatus as error:
        return error.response.status_code


def test_a_token_comes_in_the_header_alone(serve):
    _, server = serve(token=TOKEN)
    assert status(server, f'?token={TOKEN}') == 401
    for given in ('', 'Bearer', 'Bearer wrong-token', f'Basic {TOKEN}', f'Bearer {TOKEN}x'):
        assert status(server, authorization=given) == 401
        assert socket_status(server, authorization=given) == 403
    assert status(server, authorization=f'Bearer {TOKEN}') == 200
    assert socket_status(server, authorization=f'bearer {TOKEN}') == 101


def test_only_pages_that_are_named_may_read(serve):
    own = 'https://example.org'
    _, server = serve(origins=(own,))
    assert status(server, host='example.org') == 403
    assert status(server, origin='https://other.org') == 403
    assert socket_status(server, origin='https://other.org') == 403
    assert status(server, origin=own) == 200
    answer = httpx.options(
        address(server, 'tracks.xml'),
        headers={'origin': own, 'access-control-request-method': 'GET'},
    )
    assert answer.headers['access-control-allow-origin'] == own


def test_others_reach_it_only_with_a_token(serve):
    with pytest.raises(ValueError, match='MCTRACK_STREAM_TOKEN'):
        serve(host='0.0.0.0')
    serve(host='0.0.0.0', token=TOKEN)


def test_it_can_only_be_read(serve):
    hub, server = serve()
    assert httpx.get(address(server)).text.split() == [f'/{name}' for name in hub.profiles]
    assert status(server, method='POST') == 405
    assert status(server, method='HEAD') == 200
    assert status(server, 'nothing') == 404
    assert status(server, 'tracks.xml?since=yesterday') == 400
    assert status(server, body=b'hello') == 413
    assert status(server, body=iter([b'hello'])) == 413


def test_no_more_may_read_than_the_limit(serve):
    hub, server = serve(readers=2)
    first, _ = Listener(server, 'tracks.xml'), Listener(server, 'tracks.xml')
    until(lambda: hub.count == 2)
    answer = httpx.get(address(server, 'tracks.xml'))
    assert (answer.status_code, answer.headers['retry-after']) == (503, '5')
    assert socket_status(server) == 403
    end(hub, server)
    first.join(PATIENCE_S)
    until(lambda: hub.count == 0)
    assert status(server) == 200


def opened(server, buffer=None):
    """Return a connection, with a receive buffer of so many bytes."""
    connection = socket.socket()
    if buffer:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    connection.settimeout(PATIENCE_S)
    connection.connect(('127.0.0.1', server.port))
    return connection


REQUESTS = {
    'http': b'GET /tracks.xml HTTP/1.1\r\nHost: localhost\r\n\r\n',
    'web socket': b'GET /tracks.xml HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\n'
    b'Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
    b'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n',
}


@pytest.mark.parametrize('request_text', REQUESTS.values(), ids=REQUESTS)
def test_who_reads_too_slowly_is_dropped_and_others_are_not(serve, request_text):
    hub, server = serve()
    listener = Listener(server, 'tracks.json')
    with opened(server, 4096) as slow:
        slow.sendall(request_text)
        until(lambda: hub.count == 2)
        sent = 0
        for frame in walk(0, 20_000, people=40):
            hub.publish(frame)
            sent += 1
            if hub.dropped:
                break
            until(lambda sent=sent: listener.body.count(b'\n') > sent - MOST_WAITING // 2)
        assert hub.dropped == 1
        until(lambda: hub.count == 1)
        until(lambda: listener.body.count(b'\n') == sent + 1)
        with contextlib.suppress(ConnectionResetError):
            while slow.recv(65536):  # what the kernel still had, then the end
                pass
    assert listener.is_alive()


def test_who_does_not_read_the_past_he_asked_for_is_dropped(serve, monkeypatch):
    monkeypatch.setattr(hub_module, 'STUCK_S', 0.3)
    hub, server = serve()
    frames = walk(0, 400, people=40)
    for frame in frames[:300]:
        hub.publish(frame)
    with opened(server, 4096) as slow:
        slow.sendall(REQUESTS['http'].replace(b'.xml', b'.xml?since=0'))
        until(lambda: hub.count == 1)
        fresh = iter(frames[300:])

        def publish_until_dropped():
            hub.publish(next(fresh))
            time.sleep(0.05)
            return hub.dropped

        until(publish_until_dropped)
        until(lambda: hub.count == 0)


def is_cut_off(connection):
    """Tell whether a connection is ended without more than a short answer."""
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(65536):
            assert b'HTTP/1.1 4' in part or b'Invalid' in part
    return True


@pytest.mark.parametrize('text', [b'', b'GET /tracks.xml HTTP/1.1\r\nHost: local', b'\0'])
def test_who_does_not_finish_to_ask_is_cut_off(serve, monkeypatch, text):
    monkeypatch.setattr(connections, 'REQUEST_S', 0.3)
    _, server = serve()
    with opened(server) as connection:
        connection.sendall(text)
        assert is_cut_off(connection)


@pytest.mark.parametrize(
    'text',
    [
        b'\x16\x03\x01\x02\x00' + b'\xff' * 600,
        b'GET / HTTP/1.1\r\n' + b'x' * 20_000,
        b'GET /' + b'a' * 20_000,
        b'GET /tracks.xml HTTP/1.1\r\nHost: localhost\r\nA: ' + b'b' * 2_000_000 + b'\r\n\r\n',
    ],
    ids=['garbage', 'no line end', 'long line', 'large header'],
)
def test_garbage_is_refused_and_the_server_goes_on(serve, text):
    _, server = serve()
    with opened(server) as connection:
        with contextlib.suppress(ConnectionError):
            connection.sendall(text)
        assert is_cut_off(connection)
    assert status(server) == 200


def test_there_are_not_more_connections_than_the_limit(serve):
    _, server = serve(readers=2)
    with contextlib.ExitStack() as stack:
        crowd = [stack.enter_context(opened(server)) for _ in range(80)]
        until(lambda: server.connections == 66)
        for connection in crowd[66:]:
            assert is_cut_off(connection)
    until(lambda: not server.connections)
    assert status(server) == 200


def test_a_port_that_is_taken_is_named(serve):
    _, server = serve()
    with pytest.raises(OSError, match=f'127.0.0.1:{server.port} cannot be used'):
        serve(port=server.port)


def test_a_stream_ends_whole_when_the_server_does(serve):
    hub, server = serve()
    listener = Listener(server, 'tracks.xml', **{'accept-encoding': 'gzip'})
    until(lambda: hub.count == 1 and listener.body)
    server.close()
    etree.fromstring(listener.text().encode())


def test_gzip_is_whole(serve):
    hub, server = serve()
    with opened(server) as connection:
        text = REQUESTS['http'].replace(b'\r\n\r\n', b'\r\nAccept-Encoding: gzip\r\n\r\n')
        connection.sendall(text.replace(b'HTTP/1.1', b'HTTP/1.0'))
        until(lambda: hub.count == 1)
        hub.publish(walk(0, 1)[0])
        end(hub, server)
        answer = b''
        while part := connection.recv(65536):
            answer += part
    assert stamps(gzip.decompress(answer.partition(b'\r\n\r\n')[2]).decode()) == [stamp_ns(0)]
