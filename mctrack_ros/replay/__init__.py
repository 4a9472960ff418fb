"""Bags through the pipelines in lock step, without DDS."""
