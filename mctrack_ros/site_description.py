"""What `/site` says: enough to decode a bag years later."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from mctrack_ros.interfaces import code_tables

LAYOUT_VERSION = 1
"""Of the clouds' fields; counts up when a field changes its meaning."""


def site_description(configuration: Mapping[str, Any], cameras: list[str]) -> str:
    """Return the JSON of `/site`: layout version, camera order, origin, codes, settings."""
    canonical = json.dumps(configuration, sort_keys=True)
    return json.dumps(
        {
            'layout_version': LAYOUT_VERSION,
            'cameras': cameras,
            'origin': configuration['origin'],
            'codes': code_tables(),
            'configuration_hash': hashlib.sha256(canonical.encode()).hexdigest(),
            'fusion': configuration['fusion'],
        },
        sort_keys=True,
    )
