"""In which forms a stream is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from mctrack_ros.streams.formats import onvif, trajectory
from mctrack_ros.streams.formats.geo import GeoReference
from mctrack_ros.streams.frames import About, Frame


@dataclass(frozen=True, slots=True)
class Profile:
    """
    A form: a head, an element a frame, a tail.

    Attributes
    ----------
    name : str
        Last part of its address.
    media_type : str
        For HTTP.
    head, frame : callable
        Return the text of the stream's beginning and of a frame.
    tail : str
        What a complete stream ends with.
    wraps : bool
        Whether a frame is a document only between head and tail; else each is one by itself.

    """

    name: str
    media_type: str
    head: Callable[[About], str]
    frame: Callable[[Frame], str]
    tail: str = ''
    wraps: bool = True

    def message(self, head: str, text: str) -> str:
        """Return a frame's text as a message of its own."""
        return f'{head}{text}{self.tail}' if self.wraps else text


def all_profiles(geo: GeoReference | None = None) -> tuple[Profile, ...]:
    """Return the forms; ONVIF's has longitudes and latitudes where it is known where 0,0 is."""
    return (
        Profile(
            'tracks.xml',
            'application/xml',
            trajectory.xml_head,
            trajectory.xml_frame,
            trajectory.XML_TAIL,
        ),
        Profile(
            'tracks.json',
            'application/x-ndjson',
            trajectory.json_head,
            trajectory.json_frame,
            wraps=False,
        ),
        Profile(
            'onvif.xml',
            'application/xml',
            lambda _: onvif.XML_HEAD,
            partial(onvif.xml_frame, geo=geo),
            onvif.XML_TAIL,
        ),
    )
