"""How likely a person stands in each cell of the ground, by one camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.rows import POSITION, Column, Rows

NO_EDGE = -4.5
"""Log-likelihood where an outline meets no edge: -D_max^2 / 2 R^2 with D_max = 3 R."""


@dataclass(frozen=True, eq=False, slots=True)
class Likelihood(Rows):
    """
    Log-likelihoods of one image on a grid, row by row from the lowest x and y; none: not known.

    Attributes
    ----------
    position : (n, 3) float32 array
        Centres of the cells on the ground, m, those of a site's cameras the same.
    log_likelihood : (n,) float32 array
        Of a person there, 0 at most; NaN where too little of him would be in the image.

    """

    TOPIC: ClassVar[str] = 'likelihood'
    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'log_likelihood': Column('f4', (), float('nan')),
    }

    position: NDArray[np.float32]
    log_likelihood: NDArray[np.float32]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the grid."""
        columns = int((self.position[:, 1] == self.position[:1, 1]).sum())
        return (len(self) // columns, columns) if columns else (0, 0)
