"""PETS 2009 S2.L1, both ways: one camera from pixels, six views from stored detections."""

from __future__ import annotations

from pathlib import Path

from mctrack_experiments.real.pets_pixels import pets_pixels
from mctrack_experiments.real.stored.detections import reproduce_pets_multiview
from mctrack_ros.evaluation.figures import Figures


def reproduce_pets(data: Path) -> Figures:
    """Measure both ways and put the figures together."""
    halves = {
        'pixels': pets_pixels(data / 'pets2009_s2l1'),
        'multiview': reproduce_pets_multiview(data),
    }
    protocol = {
        f'{half}.{name}': value
        for half, figures in halves.items()
        for name, value in figures.protocol.items()
        if name != 'machine'
    }
    together = {n: v for figures in halves.values() for n, v in figures.figures.items()}
    return Figures('pets', 'mctrack reproduce pets', protocol, together)
