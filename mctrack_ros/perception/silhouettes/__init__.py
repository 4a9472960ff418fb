"""The object tracker of the silhouettes paper, one step a file; `tracker` runs them in order."""

from mctrack_ros.perception.silhouettes.config import (
    SilhouetteCameraConfig,
    SilhouetteConfig,
    as_printed,
)
from mctrack_ros.perception.silhouettes.pipeline import SilhouettePipeline
from mctrack_ros.perception.silhouettes.reporting import TrackedObjects

__all__ = [
    'SilhouetteCameraConfig',
    'SilhouetteConfig',
    'SilhouettePipeline',
    'TrackedObjects',
    'as_printed',
]
