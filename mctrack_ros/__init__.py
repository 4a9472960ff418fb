"""Multi-camera tracking on the ground plane as a ROS 2 node graph."""

__version__ = '0.1.0'
