"""Which topics hold pictures, and which sites want none recorded."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from mctrack_ros.input_size import SITE

SITE_TYPE = 'std_msgs/msg/String'
_PICTURES = re.compile(r'/\w*(Image|Video|Packet)\w*$')
"""Image, CompressedImage, DisparityImage, CompressedVideo, the packets of video transports."""


def are_pictures(kinds: Sequence[str]) -> bool:
    """Tell whether messages of one of some types are pictures, by the types' names."""
    return any(_PICTURES.search(kind) for kind in kinds)


def is_private(description: str) -> bool:
    """Tell whether a site is private by what `/site` says; anything else says nothing."""
    if len(description) > SITE:
        return False
    try:
        said = json.loads(description)
    except (ValueError, RecursionError):
        return False
    return isinstance(said, dict) and said.get('private') is True
