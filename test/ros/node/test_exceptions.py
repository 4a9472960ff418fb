"""No exception of a callback ends a node."""

import subprocess
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import CompressedImage

from mctrack_ros.interfaces import Detections
from walker import PERIOD_NS, camera_parameters, walker_message

FAULTY = """
import sys
from mctrack_ros.ros.nodes.camera_node import CameraNode
from mctrack_ros.ros.node.process import run

class Faulty(CameraNode):
    seen = 0

    def on_image(self, message):
        self.seen += 1
        if self.seen <= 2:
            raise IndexError('index 3 is out\\nof bounds')
        super().on_image(message)

sys.exit(run(Faulty))
"""


@pytest.mark.live
def test_a_node_lives_on_after_an_exception_and_says_so(bench, projection):
    bench.open()
    parameters = bench.parameter_file('faulty', camera_parameters(projection))
    with open(bench.folder / 'faulty.log', 'w') as log:
        command = [sys.executable, '-c', FAULTY, '--ros-args', '--params-file', str(parameters)]
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    bench.processes.append(process)
    detections = bench.rows(Detections, '/cam1/detections')
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    images = bench.publisher(CompressedImage, '/cam1/image_raw/compressed')
    bench.heard('/cam1/detections')
    sent = iter(range(1000))

    def is_seen():
        index = next(sent)
        images.publish(walker_message(index, (index + 1) * PERIOD_NS))
        return detections

    bench.until(is_seen)
    bench.until(lambda: reports and reports[-1].status[-1].message.startswith('2 so far'))
    status = next(s for report in reports for s in report.status if 'so far' in s.message)
    assert status.name.endswith('exceptions')
    assert status.level in (DiagnosticStatus.ERROR, DiagnosticStatus.WARN)
    assert 'IndexError: index 3 is out of bounds (<string>:' in status.message
    assert process.poll() is None
    said = [line for line in bench.log('faulty').splitlines() if 'IndexError' in line]
    assert len(said) == 1
    assert said[0].endswith('the node goes on')
