"""Hypothesis strategies that several tests share."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from mctrack_ros.interfaces import Detections, Events, Feedback, Ticks, Tracks

ROW_TYPES = (Detections, Events, Feedback, Ticks, Tracks)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)


def columns(kind, count):
    """Draw every column of a row type: finite numbers, symmetric matrices."""

    def values(column):
        elements = None
        if column.dtype[0] == 'f':
            elements = st.floats(-1e6, 1e6, width=32)
        drawn = hnp.arrays(np.dtype(column.dtype), (count, *column.shape), elements=elements)
        if len(column.shape) == 2:
            return drawn.map(lambda array: np.triu(array) + np.triu(array, 1).swapaxes(1, 2))
        return drawn

    return st.fixed_dictionaries({name: values(c) for name, c in kind.COLUMNS.items()})


@st.composite
def rows(draw, kinds=ROW_TYPES, most=4):
    """Draw rows of one of some types."""
    kind = draw(st.sampled_from(kinds))
    return kind(stamp_ns=draw(STAMPS), **draw(columns(kind, draw(st.integers(0, most)))))
