"""Video files with pictures at chosen times."""

from fractions import Fraction

import av
import cv2
import numpy as np

SIZE = (64, 48)


def level_picture(index, size=SIZE):
    """Return a flat picture, brighter with each index, (height, width, 3)."""
    return np.full((size[1], size[0], 3), 20 + 10 * (index % 20), np.uint8)


def write_film(path, times_s, pictures=None, codec='libx264', time_base=1000, **options):
    """
    Write pictures at given times; the kind of file follows from the name.

    Unless given, pictures are those of `level_picture`; options are those of the container.
    """
    pictures = pictures or [level_picture(index) for index in range(len(times_s))]
    height, width = pictures[0].shape[:2]
    unit = Fraction(1, time_base)
    with av.open(str(path), 'w', options=options) as container:
        stream = container.add_stream(codec, rate=25)
        stream.width, stream.height = width, height
        stream.pix_fmt = 'yuvj420p' if codec == 'mjpeg' else 'yuv420p'
        stream.codec_context.time_base = unit
        for time_s, picture in zip(times_s, pictures, strict=True):
            frame = av.VideoFrame.from_ndarray(picture, 'bgr24')
            frame.pts, frame.time_base = round(time_s / unit), unit
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def write_steady_film(path, count, rate=25.0, size=SIZE):
    """Write pictures at a steady rate, as OpenCV does."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), rate, size)
    for index in range(count):
        writer.write(level_picture(index, size))
    writer.release()
    return path


def cut(path, share):
    """Keep the first share of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: round(share * len(data))])
    return path
