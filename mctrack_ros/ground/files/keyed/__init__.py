"""Cameras as named values: what the keys of OpenCV, ROS and other tools mean."""
