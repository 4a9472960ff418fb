"""What the tests of streams share: frames, and servers that end."""

import contextlib

import pytest

from mctrack_ros.streams.formats.profiles import all_profiles
from mctrack_ros.streams.serve.hub import Hub
from mctrack_ros.streams.serve.server import Place, StreamServer
from stream_story import ABOUT, frames_of, story


@pytest.fixture(scope='session')
def frames():
    """Return the frames of the story."""
    return frames_of(story())


@pytest.fixture
def serve():
    """Return what serves a hub; all is ended after the test."""
    with contextlib.ExitStack() as stack:

        def serving(history=None, memory_s=60.0, readers=8, **place):
            hub = Hub(all_profiles(), memory_s, readers, history)
            server = StreamServer(hub, Place(**place), readers)
            server.start()
            stack.callback(server.close)
            hub.describe(ABOUT)
            return hub, server

        yield serving
