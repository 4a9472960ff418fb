"""
Bags through the pipelines in lock step, without DDS.

Nothing is imported here: the cameras' processes need no fusion.
"""
