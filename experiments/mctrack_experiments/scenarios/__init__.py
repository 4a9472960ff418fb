"""Scenarios of which each asks one thing of fusion, over many seeds; the last part is images."""
