"""Camera images with the recorded detections drawn in."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import jpeg_from_image
from mctrack_ros.interfaces import Events
from mctrack_ros.perception.overlay import Overlay
from mctrack_ros.report.session import Session, detections_near, image_at

Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class CameraImage:
    """
    One camera's image for the page.

    Attributes
    ----------
    camera : str
        Its name.
    caption : str
        What is in it.
    jpeg : str
        The image as a ``data:`` address.

    """

    camera: str
    caption: str
    jpeg: str


def camera_images(session: Session, stamp_ns: int) -> list[CameraImage]:
    """Return the images of all cameras that have one near a stamp, detections drawn in."""
    images = []
    for camera in session.cameras:
        detections = detections_near(session, camera, stamp_ns)
        stamp = stamp_ns if detections is None else detections.stamp_ns
        image = image_at(session, camera, stamp)
        if image is None:
            continue
        if detections is None:
            caption = 'no detections recorded'
        else:
            image = Overlay().draw(image, detections, Events.build(stamp))
            known = int((detections.track_id > 0).sum())
            caption = f'{len(detections)} detections, {known} with a global id'
        images.append(CameraImage(camera, caption, data_address(image)))
    return images


def data_address(image: Image, quality: int = 82) -> str:
    """Return a (height, width, 3) image as a JPEG ``data:`` address."""
    encoded = base64.b64encode(jpeg_from_image(image, quality).tobytes()).decode()
    return f'data:image/jpeg;base64,{encoded}'
