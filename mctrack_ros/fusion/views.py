"""How the cameras of a site see the ground, for the trackers that have to know."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:  # a process that needs no calibrations loads none
    from mctrack_ros.ground import GroundMapping
    from mctrack_ros.ground.coverage.field_of_view import Region


class Views(NamedTuple):
    """
    The cameras' views.

    Attributes
    ----------
    mappings : mapping of str to GroundMapping
        By the camera's name.
    area : Polygon or MultiPolygon, optional
        Where people are looked for, m; None: wherever they are seen.

    """

    mappings: Mapping[str, GroundMapping]
    area: Region | None = None


OpenViews = Callable[[], Views]
"""Reads them; ConfigError or CalibrationError: they are not known."""
