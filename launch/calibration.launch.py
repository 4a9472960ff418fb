"""Calibrate a camera in the browser."""

from mctrack_ros.cli.launch_files import CALIBRATION, calibrate_command
from mctrack_ros.ros.graph.launch_actions import described_command


def generate_launch_description():
    return described_command(CALIBRATION, calibrate_command)
