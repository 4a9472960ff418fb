"""The background model alone, on real images with masks, beside other projects' in one run."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mctrack_experiments
from mctrack_experiments.real.foreground.sequences import SEQUENCES, Subtractor, images, measure
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.background.objects import objects_in
from mctrack_ros.perception.background.plate import spread_median
from mctrack_ros.perception.blobs.extraction import BlobConfig, clean_mask

Image = NDArray[np.uint8]
PEERS = 'MCTRACK_PEERS'
"""Names the Python interpreter of the environment that has the peers."""
SPREAD = 49


def reproduce_foreground(data: Path) -> Figures:
    """Measure our model, and the peers if an environment has them, on all sequences."""
    figures = {f'ours.{name}': value for name, value in measure(data, ours).items()}
    figures |= {f'offline.{name}': value for name, value in _offline(data).items()}
    others = _peers(data)
    for name, peer in others.items():
        figures |= {f'{name}.{figure}': value for figure, value in peer['figures'].items()}
    for sequence in SEQUENCES:
        best = max((figures[f'{name}.{sequence}.f'] for name in others), default=np.nan)
        figures[f'peers.{sequence}.f_max'] = best
    protocol = {
        'data': 'highway and office of CDnet 2014, images 300-770 and 400-1200, scored from 470 '
        'and 570; corridor of SBI2015, all 610 images; 320 x 240 to 384 x 256 px',
        'f': 'over all scored pixels of a sequence; shadows count as background',
        'ours': 'defaults, from the first image on, 25 images a second, without a tracker that '
        'says who walked in; the mask that blobs and occupancy are given',
        'offline': 'the same, begun with the median of images spread over the sequence',
        'images_a_second': 'highway, 320 x 240 px, one core, processor time, without reading',
        'peers': {name: peer['what'] for name, peer in others.items()}
        or f'not measured: {PEERS} names no Python',
    }
    return Figures('foreground', 'mctrack reproduce foreground', protocol, figures)


def ours(background: Image | None = None) -> Subtractor:
    """Begin our model as a camera has it, with a background or without."""
    model, cleaning = Background(BackgroundConfig()), BlobConfig()
    if background is not None:
        model.begin(background)

    def subtract(image: Image, stamp_ns: int) -> Image | None:
        found = model.apply(image, stamp_ns)
        if found is None or model.model is None:
            return None
        cleaned = clean_mask(found, model.difference, model.threshold, cleaning)
        mask = objects_in(image, model.model, cleaned)
        nobody = np.zeros_like(mask)
        model.learn(image, mask, nobody, nobody, stamp_ns)
        return mask

    return subtract


def _offline(data: Path) -> dict[str, float]:
    """Return the figures of our model with a background from all of each sequence."""
    plates = iter(
        spread_median([image for _, image, _ in given[:: max(len(given) // SPREAD, 1)]])
        for given in (images(data, sequence) for sequence in SEQUENCES)
    )
    return measure(data, lambda: ours(next(plates)))


def _peers(data: Path) -> dict[str, Any]:
    """Run the peers in their environment; return what they are and their figures, by name."""
    python = os.environ.get(PEERS)
    if not python:
        return {}
    here = Path(mctrack_experiments.__file__).parents[1]
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / 'peers.json'
        module = 'mctrack_experiments.real.foreground.peers'
        subprocess.run(
            [python, '-m', module, str(data.resolve()), str(out)],
            env={**os.environ, 'PYTHONPATH': str(here)},
            check=True,
        )
        found: dict[str, Any] = json.loads(out.read_text())
    return found
