"""Where one camera sees something that moves: a mask of few pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, slots=True)
class Foreground:
    """
    The foreground of one image, reduced.

    Attributes
    ----------
    stamp_ns : int
        Of the image, ns.
    mask : (h, w) uint8 array
        255 where there is foreground, else 0; read-only. Of no pixels: it is not known, as long
        as the background is learned or after the camera has moved.

    """

    TOPIC: ClassVar[str] = 'foreground/compressed'
    ROS_TYPE: ClassVar[str] = 'sensor_msgs/msg/CompressedImage'

    stamp_ns: int
    mask: NDArray[np.uint8]

    def __post_init__(self) -> None:
        """Refuse what is no mask, and freeze it."""
        if self.mask.ndim != 2 or self.mask.dtype != np.uint8:
            raise ValueError(
                f'mask has shape {self.mask.shape} and type {self.mask.dtype}, '
                'expected (height, width) and uint8'
            )
        self.mask.setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Go to another process as one bit a pixel: an eighth is copied through the pipe."""
        return _unpacked, (self.stamp_ns, self.mask.shape, np.packbits(self.mask).tobytes())

    def __len__(self) -> int:
        """Return the number of pixels that are foreground."""
        return int(np.count_nonzero(self.mask))

    @classmethod
    def build(cls, stamp_ns: int) -> Self:
        """Return the foreground of an image of which none is known."""
        return cls(stamp_ns, np.zeros((0, 0), np.uint8))

    def at(self, stamp_ns: int) -> Self:
        """Return the same foreground under another stamp, ns."""
        return replace(self, stamp_ns=stamp_ns)


def _unpacked(stamp_ns: int, shape: tuple[int, int], bits: bytes) -> Foreground:
    mask = np.unpackbits(np.frombuffer(bits, np.uint8), count=shape[0] * shape[1])
    return Foreground(stamp_ns, np.negative(mask).reshape(shape))
