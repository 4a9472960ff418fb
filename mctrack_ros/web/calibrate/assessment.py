"""What the pairs say about the camera, in words and numbers for the page."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.ground import CameraFit, GridError
from mctrack_ros.web.calibrate.pairing import Pairing


@dataclass(frozen=True, slots=True)
class Assessment:
    """
    What stands beside the image.

    Attributes
    ----------
    headline : str
        Whether there is a camera, and how well it fits.
    details : tuple of str
        What else is known of it.
    warnings : tuple of str
        What a person should look at.
    kind : str
        ``good``, ``bad`` (look at a point) or ``open`` (no camera yet).

    """

    headline: str
    details: tuple[str, ...]
    warnings: tuple[str, ...]
    kind: str


def assessed(pairing: Pairing) -> Assessment:
    """Judge the pairs."""
    warnings = [*_suspicions(pairing), *_cells(pairing)]
    if pairing.fit is None:
        return Assessment('No camera yet', (_sentence(pairing.reason),), tuple(warnings), 'open')
    fit = pairing.fit
    headline = f'Fits to {fit.rms_px:.2f} px (rms of {len(fit.ground)} points)'
    kind = 'bad' if pairing.suspicious() else 'good'
    return Assessment(headline, (_uncertainty(fit), _where(fit)), tuple(warnings), kind)


def point_rows(pairing: Pairing) -> list[dict[str, str | float | None]]:
    """Return a row a pair: name, x and y (m), column and row (px), residual (px)."""
    residual = pairing.residual_px()
    at = dict(zip(pairing.names, pairing.ground.tolist()))
    return [
        {
            'name': name,
            'ground': f'{at[name][0]:.12g}, {at[name][1]:.12g}',
            'pixel': f'{x:.1f}, {y:.1f}',
            'residual': round(residual[name], 2) if name in residual else None,
        }
        for name, (x, y) in pairing.pairs.items()
    ]


def _suspicions(pairing: Pairing) -> list[str]:
    residual = pairing.residual_px()
    return [
        f'Point {name} is {residual[name]:.1f} px off: check it' for name in pairing.suspicious()
    ]


def _cells(pairing: Pairing) -> list[str]:
    """Say which points a saved file will not hold."""
    if len(pairing.pairs) < 4:
        return []
    try:
        _, ignored = pairing.grid()
    except GridError as error:
        return [f'Cannot be saved: {error}']
    return [f'In no complete cell, not saved: {", ".join(ignored)}'] if ignored else []


def _uncertainty(fit: CameraFit) -> str:
    covariance = fit.mapping.calibration_covariance(fit.ground)
    deviation = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 2)
    return (
        f'Ground positions known to {np.median(deviation):.2g} m at the points '
        f'({deviation.max():.2g} m at the worst)'
    )


def _where(fit: CameraFit) -> str:
    camera = fit.mapping.camera
    x, y, z = fit.mapping.camera_position.tolist()
    return (
        f'Camera at ({x:.1f}, {y:.1f}) m, {z:.1f} m high; focal length '
        f'{camera.intrinsics[0]:.0f} px, k1 {camera.distortion[0]:+.3f}'
    )


def _sentence(reason: str) -> str:
    return reason[:1].upper() + reason[1:]
