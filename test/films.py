"""Video files with images at chosen times."""

from fractions import Fraction

import av
import cv2
import numpy as np

SIZE = (64, 48)


def level_image(index, size=SIZE):
    """Return a flat image, brighter with each index, (height, width, 3)."""
    return np.full((size[1], size[0], 3), 20 + 10 * (index % 20), np.uint8)


def write_film(path, times_s, images=None, codec='libx264', time_base=1000, **options):
    """
    Write images at given times; the kind of file follows from the name.

    Unless given, images are those of `level_image`; options are those of the container.
    """
    images = images or [level_image(index) for index in range(len(times_s))]
    height, width = images[0].shape[:2]
    unit = Fraction(1, time_base)
    with av.open(str(path), 'w', options=options) as container:
        stream = container.add_stream(codec, rate=25)
        stream.width, stream.height = width, height
        stream.pix_fmt = 'yuvj420p' if codec == 'mjpeg' else 'yuv420p'
        stream.codec_context.time_base = unit
        for time_s, image in zip(times_s, images, strict=True):
            frame = av.VideoFrame.from_ndarray(image, 'bgr24')
            frame.pts, frame.time_base = round(time_s / unit), unit
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def write_steady_film(path, count, rate=25.0, size=SIZE):
    """Write images at a steady rate, as OpenCV does."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), rate, size)
    for index in range(count):
        writer.write(level_image(index, size))
    writer.release()
    return path


def cut(path, share):
    """Keep the first share of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: round(share * len(data))])
    return path
