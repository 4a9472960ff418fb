"""What `/site` says: enough to decode a bag years later."""

from __future__ import annotations

import hashlib
import json
from base64 import b64encode
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from mctrack_ros.interfaces import code_tables

LAYOUT_VERSION = 1
"""Of the clouds' fields; counts up when a field changes its meaning."""


STATE = 'state'
"""Key under which the state of a tracker stands, base64."""


class Beginning(NamedTuple):
    """
    How a run begins, so that it can be replayed.

    Attributes
    ----------
    first_id : int
        Id of the first track that may begin.
    made_by : mapping of str to str
        Of a live run, versions and processor.
    state : bytes
        Of the tracker, as `dump_state` returns it; empty: there are no tracks yet.

    """

    first_id: int = 1
    made_by: Mapping[str, str] = MappingProxyType({})
    state: bytes = b''


def site_description(
    configuration: Mapping[str, Any],
    cameras: list[str],
    run: str,
    image_sizes: Mapping[str, tuple[int, int]],
    beginning: Beginning | None = None,
) -> str:
    """
    Return the JSON of `/site`: layout version, run, camera order, origin, codes, zones, settings.

    With the width and height of cameras' images, px, as far as known: over the size of a
    foreground mask they give its scale. ``private`` stands in it if no picture may be recorded.
    Zones and lines are relative to the origin, as positions on topics are; rows of events name
    them by index. With the id of the first track that may begin, and of a live run with the
    versions and the processor, so that it can be replayed; if it goes on where an earlier process
    ended, or parameters were changed, with the state of the tracker from there on.
    Clock offsets, s, are those that were taken from the stamps of the cameras' detections in a
    bag.
    """
    beginning = beginning or Beginning()
    private = {'private': True} if configuration.get('private') else {}
    state = {STATE: b64encode(beginning.state).decode()} if beginning.state else {}
    return json.dumps(
        private
        | state
        | {
            'layout_version': LAYOUT_VERSION,
            'run': run,
            'cameras': cameras,
            'image_sizes': image_sizes,
            'first_id': beginning.first_id,
            'made_by': dict(beginning.made_by),
            'origin': configuration['origin'],
            'codes': code_tables(),
            'zones': configuration.get('zones', []),
            'clock_offsets': configuration.get('clock_offsets', {}),
            'configuration_hash': _digest(configuration),
            'fusion': configuration['fusion'],
        },
        sort_keys=True,
    )


def offline_run(configuration: Mapping[str, Any], began_ns: int) -> str:
    """Return what a run over a recording is called: the same for the same settings and start."""
    return _digest({'configuration': configuration, 'began_ns': began_ns})[:32]


def _digest(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
