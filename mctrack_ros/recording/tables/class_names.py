"""What text calls the classes that this package knows."""

from __future__ import annotations

from collections.abc import Mapping

from mctrack_ros.interfaces import ClassCode

CLASS_NAMES: Mapping[str, ClassCode] = {
    **{code.name.lower(): code for code in ClassCode},
    **dict.fromkeys(('pedestrian', 'people', 'human', 'static person'), ClassCode.PERSON),
    **dict.fromkeys(('car', 'truck', 'bus', 'van', 'motorcycle', 'motorbike'), ClassCode.VEHICLE),
    'bike': ClassCode.BICYCLE,
    'sports ball': ClassCode.BALL,
}
"""In small letters: the names of `ClassCode`, and those of usual detectors."""
