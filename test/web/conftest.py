"""What the tests of pages share: a browser, and a page that a command serves."""

import contextlib
import os
import shutil
import socket
import subprocess
import sys

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser'))), None)
TOKEN = 'for-the-browser-test'


@pytest.fixture(scope='module')
def browser():
    """Return a headless Chromium; while it runs, this process has an event loop."""
    if CHROMIUM is None:
        pytest.skip('browser tests left out: no chromium installed')
    api = pytest.importorskip('playwright.sync_api', reason='browser tests left out: playwright')
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, chromium_sandbox=os.geteuid() != 0
        )
        yield chromium
        chromium.close()


def free_port():
    """Return a port that nobody uses now."""
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        return free.getsockname()[1]


@contextlib.contextmanager
def served(folder, *command, port=None):
    """Run `mctrack` with a command that serves a page, at any port or a given one."""
    port = port or free_port()
    options = ['--no-browser', '--port', str(port), '--token', TOKEN]
    environment = {name: text for name, text in os.environ.items() if 'PYTEST' not in name}
    server = subprocess.Popen(
        [sys.executable, '-m', 'mctrack_ros.cli.main', *command, *options],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        lines = iter(server.stdout.readline, '')
        address = next((line.split()[0] for line in lines if line.startswith('http')), None)
        assert address, 'the command ended without serving a page'
        assert TOKEN not in address
        yield f'{address}?token={TOKEN}'
    finally:
        server.terminate()
        assert server.wait(30) in (0, -15)


@pytest.fixture(scope='session')
def serve():
    """Return `served`."""
    return served
