import json
import shutil
import socket
import subprocess
import time
from collections import defaultdict
from dataclasses import dataclass, field

import pytest
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from mctrack_ros.config import ConfigError
from mctrack_ros.streams import credentials
from mctrack_ros.streams.formats import onvif
from mctrack_ros.streams.mqtt import MqttConfig, MqttPublisher
from stream_story import frames_of, stamp_ns, tracks

PATIENCE_S = 30.0
MOSQUITTO = shutil.which('mosquitto') or shutil.which('mosquitto', path='/usr/sbin')
USER, PASSWORD = 'tracker', 'for-the-broker-test'


def until(condition):
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, 'what was waited for did not happen'
        time.sleep(0.01)


def certificate(folder):
    """Return the files of a certificate for this machine and of its key."""
    made, key = folder / 'certificate.pem', folder / 'key.pem'
    subject = ['-subj', '/CN=127.0.0.1', '-addext', 'subjectAltName=IP:127.0.0.1']
    kind = ['-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1', '-noenc', '-days', '2']
    command = ['openssl', 'req', '-x509', *kind, *subject, '-keyout', key, '-out', made]
    subprocess.run(command, check=True, capture_output=True)
    return made, key


@dataclass
class Broker:
    """A broker that wants a password, and what a subscriber has heard from it."""

    port: int
    process: subprocess.Popen
    subscriber: Client
    certificate: str = ''
    heard: dict = field(default_factory=lambda: defaultdict(list))

    def hear(self, client, userdata, message):
        self.heard[message.topic].append(json.loads(message.payload))


@pytest.fixture
def broker(tmp_path, request):
    if MOSQUITTO is None:
        pytest.skip('MQTT tests left out: apt install mosquitto')
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        port = free.getsockname()[1]
    passwords, settings = tmp_path / 'passwords', tmp_path / 'mosquitto.conf'
    passwords.touch(0o600)
    subprocess.run(['mosquitto_passwd', '-b', passwords, USER, PASSWORD], check=True)
    settings.write_text(
        f'listener {port} 127.0.0.1\nallow_anonymous false\npassword_file {passwords}\nuser root\n'
    )
    trusted = ''
    if getattr(request, 'param', '') == 'tls':
        trusted, key = map(str, certificate(tmp_path))
        with settings.open('a') as lines:
            lines.write(f'certfile {trusted}\nkeyfile {key}\n')
    with open(tmp_path / 'log', 'w') as log:
        process = subprocess.Popen([MOSQUITTO, '-c', settings], stdout=log, stderr=log)
    subscriber = Client(CallbackAPIVersion.VERSION2)
    made = Broker(port, process, subscriber, trusted)
    if trusted:
        subscriber.tls_set(trusted)
    subscriber.username_pw_set(USER, PASSWORD)
    subscriber.on_message = made.hear
    ready = []
    subscriber.on_subscribe = lambda *_: ready.append(True)
    subscriber.on_connect = lambda client, *_: client.subscribe('hall/#', 1)
    subscriber.reconnect_delay_set(1, 1)
    subscriber.connect_async('127.0.0.1', port)
    subscriber.loop_start()
    try:
        until(lambda: ready)
        yield made
    finally:
        subscriber.disconnect()
        subscriber.loop_stop()
        process.terminate()
        process.wait(PATIENCE_S)


@pytest.fixture
def publisher(broker, tmp_path):
    (tmp_path / 'credentials').write_text(f'{USER}\n{PASSWORD}\n')
    config = MqttConfig(
        '127.0.0.1',
        broker.port,
        'hall',
        tls=bool(broker.certificate),
        ca_file=broker.certificate,
        credentials_file=str(tmp_path / 'credentials'),
    )
    made = MqttPublisher(config)
    until(lambda: made.is_connected)
    yield made
    made.close()


@pytest.mark.parametrize('broker', ['plain', 'tls'], indirect=True)
def test_frames_and_events_come_to_a_subscriber(broker, publisher, frames):
    for frame in frames:
        publisher.publish(frame)
    topic = 'hall/onvif-mj/VideoAnalytics/ground/mctrack'
    told = [each for frame in frames for each in onvif.notifications(frame)]
    until(lambda: sum(map(len, broker.heard.values())) >= len(told) + 7)
    for notification in told:
        expected = json.loads(onvif.json_event(notification))
        assert expected in broker.heard[onvif.event_topic('hall', notification)]
    sent = [frame for n, frame in enumerate(frames) if n in (0, 5) or onvif.object_tree(frame)]
    assert broker.heard[topic] == [json.loads(onvif.json_frame(frame)) for frame in sent]
    assert publisher.left_out == 0


def test_frames_come_at_the_rate_that_is_asked_for(broker, publisher):
    for frame in frames_of((tracks(n, [1, 2]), None) for n in range(50)):
        publisher.publish(frame)
    topic = onvif.metadata_topic('hall')
    until(lambda: len(broker.heard[topic]) == 10)
    times = [message['Frame'][0]['@UtcTime'] for message in broker.heard[topic]]
    assert times == [onvif.utc(stamp_ns(n)) for n in range(0, 50, 5)]


def test_what_a_broker_misses_is_left_out(broker, publisher, frames):
    broker.process.terminate()
    until(lambda: not publisher.is_connected)
    publisher.publish(frames[0])
    assert publisher.left_out == 2


def test_user_and_password_come_from_the_environment_or_a_file(monkeypatch, tmp_path):
    file = tmp_path / 'credentials'
    file.write_text(f'{USER}\n{PASSWORD}\n')
    assert credentials.user_and_password('MQTT', '') == ('', '')
    assert credentials.user_and_password('MQTT', str(file)) == (USER, PASSWORD)
    assert credentials.stream_token(str(file)) == USER
    with pytest.raises(ConfigError, match='cannot be read'):
        credentials.user_and_password('MQTT', str(tmp_path / 'none'))
    monkeypatch.setenv('MCTRACK_MQTT_USERNAME', 'other')
    monkeypatch.setenv('MCTRACK_MQTT_PASSWORD', 'secret')
    monkeypatch.setenv('MCTRACK_STREAM_TOKEN', 'token')
    assert credentials.user_and_password('MQTT', str(file)) == ('other', 'secret')
    assert credentials.user_and_password('VIDEO', str(file)) == (USER, PASSWORD)
    assert credentials.stream_token(str(file)) == 'token'


@pytest.mark.parametrize(
    'wrong', [{'prefix': ''}, {'prefix': 'a/#'}, {'tls': True, 'ca_file': '/nowhere.pem'}]
)
def test_a_wrong_setting_is_named(wrong):
    with pytest.raises(ConfigError, match=f'mqtt.{list(wrong)[-1]}'):
        MqttPublisher(MqttConfig('127.0.0.1', **wrong))
