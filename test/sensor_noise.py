"""Noise of images, cut at random from a larger field: to draw it anew costs more than to track."""

import functools

import numpy as np

MARGIN = 64


@functools.cache
def _field(shape):
    larger = (shape[0] + MARGIN, shape[1] + MARGIN, *shape[2:])
    return np.random.default_rng(20).normal(0, 1, larger).astype(np.float32)


def with_noise(image, sigma, rng):
    """Return an image as a sensor gives it, uint8; ``sigma`` is in grey levels."""
    down, right = rng.integers(MARGIN, size=2)
    part = _field(image.shape)[down : down + image.shape[0], right : right + image.shape[1]]
    return np.clip(image + sigma * part, 0, 255).astype(np.uint8)
