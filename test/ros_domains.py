"""ROS domains, one for each test that runs."""

import contextlib
import fcntl
import tempfile
from pathlib import Path

import pytest


@contextlib.contextmanager
def free_domain():
    """Give a ROS domain that no other test on this machine uses now."""
    for number in range(20, 100):
        with open(Path(tempfile.gettempdir()) / f'mctrack_domain_{number}.lock', 'w') as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield number
            return
    pytest.fail('all ROS domains are in use')
