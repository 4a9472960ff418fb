"""Track a simulated match on the shipped pitch, rendered as it goes."""

from mctrack_ros.cli.launch_files import SIMULATION, simulation_specs
from mctrack_ros.ros.graph.launch_actions import described


def generate_launch_description():
    return described(SIMULATION, simulation_specs)
