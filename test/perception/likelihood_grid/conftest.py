"""A room seen by one camera with a lens, and images of it."""

import numpy as np
import pytest

from lens_cameras import camera


@pytest.fixture
def mapping():
    """Return a camera 3 m high that looks at the origin, its lens distorted."""
    return camera(eye=(-5.0, -4.0, 3.0), target=(0.0, 0.0, 0.5), focal=450.0)


@pytest.fixture
def rng():
    """Return a seeded generator."""
    return np.random.default_rng(5)
