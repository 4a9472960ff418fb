import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

WHERE = """
import os
import sys

def report(connection):
    import mctrack_ros
    connection.send(mctrack_ros.__file__)

if __name__ == '__main__':
    import mctrack_ros
    from mctrack_ros.processes import worker_context
    before = dict(os.environ)
    context = worker_context()
    assert dict(os.environ) == before
    here, there = context.Pipe()
    process = context.Process(target=report, args=(there,))
    process.start()
    print(mctrack_ros.__file__, here.recv(), sep='\\n')
    process.join()
"""


ENDLESS = """
import os
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from mctrack_ros.processes import end_with_parent

def work():
    print(os.getpid(), flush=True)
    time.sleep(600)

if __name__ == '__main__':
    with ProcessPoolExecutor(1, get_context('spawn'), end_with_parent) as pool:
        pool.submit(work).result()
"""


def test_workers_end_when_their_parent_is_killed(tmp_path):
    program = tmp_path / 'endless.py'
    program.write_text(ENDLESS)
    environment = {**os.environ, 'PYTHONPATH': str(ROOT)}
    with subprocess.Popen(
        [sys.executable, str(program)], env=environment, stdout=subprocess.PIPE, text=True
    ) as parent:
        worker = int(parent.stdout.readline())
        assert is_running(worker)
        parent.kill()
    until = time.monotonic() + 60
    while is_running(worker):
        assert time.monotonic() < until, 'the worker goes on for a minute'
        time.sleep(0.1)


def is_running(process_id):
    try:
        return ' Z ' not in Path(f'/proc/{process_id}/stat').read_text()
    except FileNotFoundError:
        return False


@pytest.mark.parametrize('safe_path', [None, ''])
def test_workers_import_what_the_caller_did_not_what_lies_in_the_current_folder(
    tmp_path, safe_path
):
    program = tmp_path / 'bin' / 'where.py'
    program.parent.mkdir()
    program.write_text(WHERE)
    shadow = tmp_path / 'clone' / 'mctrack_ros' / 'replay'
    shadow.mkdir(parents=True)
    for folder in (shadow.parent, shadow):
        (folder / '__init__.py').write_text('')
    (shadow / 'workers.py').write_text('')
    environment = {**os.environ, 'PYTHONPATH': str(ROOT)}
    environment.pop('PYTHONSAFEPATH', None)
    if safe_path is not None:
        environment['PYTHONSAFEPATH'] = safe_path
    done = subprocess.run(
        [sys.executable, str(program)],
        cwd=tmp_path / 'clone',
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == 2 * [str(ROOT / 'mctrack_ros' / '__init__.py')]
