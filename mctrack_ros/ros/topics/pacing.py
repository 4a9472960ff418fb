"""Time in a bag against the clocks of now."""

from __future__ import annotations

import struct
from dataclasses import dataclass

SECOND_NS = 1_000_000_000

_STAMP_OFFSET = 4
"""A header's stamp follows the four bytes that open every serialised message."""


@dataclass(frozen=True, slots=True)
class Pace:
    """
    Time in the bag against the steady clock.

    Attributes
    ----------
    first_ns : int
        Log time of the first message.
    rate : float
        Speed; 1: as recorded.
    began_ns : int
        Steady time at which the first message is due.
    shift_ns : int
        What is added to the stamps.

    """

    first_ns: int
    rate: float
    began_ns: int
    shift_ns: int

    def due_ns(self, time_ns: int) -> int:
        """Return the steady time at which a message is due."""
        return self.began_ns + round((time_ns - self.first_ns) / self.rate)

    def bag_ns(self, steady_ns: int) -> int:
        """Return the time in the bag at a steady time."""
        return self.first_ns + round((steady_ns - self.began_ns) * self.rate)


def shifted(data: bytes, shift_ns: int) -> bytes:
    """Return a serialised message with the stamp of its header moved."""
    order = '<' if data[1] & 1 else '>'
    stamp = struct.Struct(order + 'iI')
    seconds, nanoseconds = stamp.unpack_from(data, _STAMP_OFFSET)
    moved = divmod(seconds * SECOND_NS + nanoseconds + shift_ns, SECOND_NS)
    end = _STAMP_OFFSET + stamp.size
    return data[:_STAMP_OFFSET] + stamp.pack(*moved) + data[end:]
