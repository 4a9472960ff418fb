"""Camera files of programs whose form is not read: how to state the same in OpenCV's form."""

from __future__ import annotations

import re

_PINHOLE = 'camera_matrix: [fx, 0, cx, 0, fy, cy, 0, 0, 1]'
_SIZE = 'image_width, image_height'
_CAMODOCAL = rb'"?model_type"?\s*:\s*"?'
_REALSENSE = rb'(?<![a-z])ppx\b|p\[[^]]*\]\s+f\['
_FORMS = (
    (
        _CAMODOCAL + rb'pinhole_full',
        f"camodocal's PINHOLE_FULL: {_PINHOLE}, distortion_model: rational_polynomial, "
        f'distortion_coefficients: [k1, k2, p1, p2, k3, k4, k5, k6], {_SIZE}',
    ),
    (
        _CAMODOCAL + rb'pinhole',
        f"camodocal's PINHOLE: {_PINHOLE}, distortion_model: plumb_bob, "
        f'distortion_coefficients: [k1, k2, p1, p2], {_SIZE}',
    ),
    (
        _CAMODOCAL + rb'kannala_brandt',
        "camodocal's KANNALA_BRANDT: camera_matrix: [mu, 0, u0, 0, mv, v0, 0, 0, 1], "
        f'distortion_model: equidistant, distortion_coefficients: [k2, k3, k4, k5], {_SIZE}',
    ),
    (
        _CAMODOCAL + rb'mei',
        "camodocal's MEI, which OpenCV's form does not hold, but Kalibr's: below cam0, "
        'camera_model: omni, intrinsics: [xi, gamma1, gamma2, u0, v0], distortion_model: radtan, '
        'distortion_coeffs: [k1, k2, p1, p2], resolution: [image_width, image_height]',
    ),
    (
        _CAMODOCAL + rb'scaramuzza',
        "camodocal's SCARAMUZZA, which no form here holds: calibrate it as KANNALA_BRANDT; then "
        'camera_matrix: [mu, 0, u0, 0, mv, v0, 0, 0, 1], distortion_model: equidistant, '
        f'distortion_coefficients: [k2, k3, k4, k5], {_SIZE}',
    ),
    (
        _REALSENSE,
        "RealSense's: of the stream that is used, camera_matrix: [fx, 0, ppx, 0, fy, ppy, 0, 0, "
        '1], distortion_coefficients: its five coeffs, distortion_model: plumb_bob (Kannala '
        'Brandt4: the first four, equidistant; Inverse Brown Conrady: only if all are 0), '
        'image_width: width, image_height: height',
    ),
    (
        rb'kannalabrandt8?',
        f"ORB-SLAM's KannalaBrandt8: {_PINHOLE}, distortion_model: equidistant, "
        f'distortion_coefficients: [k1, k2, k3, k4], {_SIZE}',
    ),
    (
        rb'(?<![a-z])fx\b',
        f'as of ORB-SLAM (Camera.fx): {_PINHOLE}, distortion_model: plumb_bob, '
        f'distortion_coefficients: [k1, k2, p1, p2, k3], zeros for what is not there, {_SIZE}',
    ),
)
"""Marks of each form, in any case, and how to write it; the first one found counts."""


def how_to_write(content: bytes) -> str:
    """Return how to write what a file of ORB-SLAM, RealSense or camodocal holds; '' for others."""
    return next((form for sign, form in _FORMS if re.search(sign, content, re.IGNORECASE)), '')
