"""Track what the cameras of a site see: camera nodes, fusion, coverage, store and stream."""

from mctrack_ros.cli.launch_files import SITE, site_specs
from mctrack_ros.ros.graph.launch_actions import described


def generate_launch_description():
    return described(SITE, site_specs)
