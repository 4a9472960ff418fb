"""Track the images of a bag, played into the graph of a site."""

from mctrack_ros.cli.launch_files import REPLAY, replay_specs
from mctrack_ros.ros.graph.launch_actions import described


def generate_launch_description():
    return described(REPLAY, replay_specs)
