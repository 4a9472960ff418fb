"""Camera pictures with the recorded detections drawn in."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import jpeg_from_image
from mctrack_ros.experiments.report.ground_plan import track_colour
from mctrack_ros.experiments.report.session import Session, detections_near, picture_at
from mctrack_ros.interfaces import Detections

Image = NDArray[np.uint8]

_UNKNOWN_BGR = (190, 190, 190)
_FONT = cv2.FONT_HERSHEY_SIMPLEX


@dataclass(frozen=True, slots=True)
class CameraPicture:
    """
    One camera's picture for the page.

    Attributes
    ----------
    camera : str
        Its name.
    caption : str
        What is in it.
    jpeg : str
        The picture as a ``data:`` address.

    """

    camera: str
    caption: str
    jpeg: str


def camera_pictures(session: Session, stamp_ns: int) -> list[CameraPicture]:
    """Return the pictures of all cameras that have one near a stamp, detections drawn in."""
    pictures = []
    for camera in session.cameras:
        detections = detections_near(session, camera, stamp_ns)
        stamp = stamp_ns if detections is None else detections.stamp_ns
        image = picture_at(session, camera, stamp)
        if image is None:
            continue
        if detections is None:
            caption = 'no detections recorded'
        else:
            image = with_detections(image, detections)
            known = int((detections.track_id > 0).sum())
            caption = f'{len(detections)} detections, {known} with a global id'
        pictures.append(CameraPicture(camera, caption, data_address(image)))
    return pictures


def with_detections(image: Image, detections: Detections) -> Image:
    """
    Draw boxes and global ids; a group's box is double and names its members.

    Parameters
    ----------
    image : (height, width, 3) uint8 array
        BGR.
    detections : Detections
        Of the same instant.

    Returns
    -------
    (height, width, 3) uint8 array
        A copy.

    """
    drawn = image.copy()
    for row in range(len(detections)):
        track_id = int(detections.track_id[row])
        members = [int(one) for one in detections.members[row] if one]
        is_group = int(detections.member_count[row]) != 1
        colour = _bgr(track_id or next(iter(members), 0))
        left, top, width, height = (round(float(value)) for value in detections.box[row])
        cv2.rectangle(drawn, (left, top), (left + width, top + height), colour, 1, cv2.LINE_AA)
        if is_group:
            corner = (left + width + 3, top + height + 3)
            cv2.rectangle(drawn, (left - 3, top - 3), corner, colour, 1, cv2.LINE_AA)
        label = '+'.join(map(str, members)) if is_group and members else str(track_id or '')
        _put_label(drawn, label, (left, top - 4), colour)
    return drawn


def data_address(image: Image, quality: int = 82) -> str:
    """Return a (height, width, 3) picture as a JPEG ``data:`` address."""
    encoded = base64.b64encode(jpeg_from_image(image, quality).tobytes()).decode()
    return f'data:image/jpeg;base64,{encoded}'


def _bgr(track_id: int) -> tuple[int, int, int]:
    red, green, blue = track_colour(track_id)
    return (blue, green, red) if track_id else _UNKNOWN_BGR


def _put_label(
    image: Image, text: str, place: tuple[int, int], colour: tuple[int, int, int]
) -> None:
    """Write on a dark outline, readable on any ground."""
    cv2.putText(image, text, place, _FONT, 0.42, (20, 20, 20), 3, cv2.LINE_AA)
    cv2.putText(image, text, place, _FONT, 0.42, colour, 1, cv2.LINE_AA)
