"""The pairs of a tick that may be true: what every associator takes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled, inner

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Pairs(NamedTuple):
    """
    Pairs of a track and a detection that pass the gate, of all images of one tick.

    In an image a track has one detection at most, and a detection one track: a track in one
    image is a *slot*. Slots and detections with the pairs as edges are one sparse graph for the
    whole tick, in which different images have nothing in common.

    Attributes
    ----------
    track, detection : (k,) int64 arrays
        Rows of the table of tracks, and of the tick's single detections.
    slot : (k,) int64 array
        Which slot each pair is of, ascending from 0; within a slot detections ascend.
    likelihood : (k,) array
        Of the pair, relative to the track being missed and the detection being false.
    image : (k,) int64 array
        Which of the tick's images each pair is in, ascending.

    """

    track: Indices
    detection: Indices
    slot: Indices
    likelihood: Floats
    image: Indices


@inner
def _root(root: Indices, pair: int) -> int:
    while root[pair] != pair:
        root[pair] = root[root[pair]]
        pair = root[pair]
    return pair


@inner
def _join(root: Indices, one: int, other: int) -> None:
    """Let the smaller root be both's, so that parts are numbered as they occur."""
    first, second = _root(root, one), _root(root, other)
    root[max(first, second)] = min(first, second)


@compiled(types.i8[::1](INTS_1D, INTS_1D))
def components(slot: Indices, detection: Indices) -> Indices:
    """Return which connected part of the graph each pair (k,) is of, numbered as they occur."""
    root = np.arange(len(slot))
    last_of = np.full(detection.max() + 1 if len(detection) else 0, -1)
    for pair in range(len(slot)):
        if pair and slot[pair] == slot[pair - 1]:
            _join(root, pair - 1, pair)
        if last_of[detection[pair]] >= 0:
            _join(root, last_of[detection[pair]], pair)
        last_of[detection[pair]] = pair
    number, count = np.empty(len(root), np.int64), 0
    for pair in range(len(root)):
        top = _root(root, pair)
        if top == pair:
            number[pair], count = count, count + 1
        else:
            number[pair] = number[top]
    return number


@inner
def numbered(values: Indices, here: Indices, numbers: Indices) -> int:
    """Give the distinct ones of some values numbers as they occur; return how many there are."""
    count = 0
    for index in range(len(here)):
        numbers[index] = count
        for before in range(index):
            if values[here[before]] == values[here[index]]:
                numbers[index] = numbers[before]
                break
        if numbers[index] == count:
            count += 1
    return count


@inner
def counted(key: Indices, keys: int) -> Indices:
    """Return the order that sorts keys (k,), not negative and below a number, stably."""
    place = np.zeros(keys + 1, np.int64)
    for one in key:
        place[one + 1] += 1
    for one in range(keys):
        place[one + 1] += place[one]
    order = np.empty(len(key), np.int64)
    for index in range(len(key)):
        order[place[key[index]]] = index
        place[key[index]] += 1
    return order
