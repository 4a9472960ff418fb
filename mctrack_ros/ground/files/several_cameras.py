"""Which camera of a file that holds several."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mctrack_ros.ground.errors import CalibrationError


@dataclass(frozen=True, slots=True)
class Choice:
    """
    Which camera is meant.

    Attributes
    ----------
    camera : str
        Its key in the file, or the topic that the file names for it; may be empty.
    topic : str
        Of its images, by which the camera is found if none is named; may be empty.

    """

    camera: str = ''
    topic: str = ''

    def of(self, topics: Mapping[str, str], where: str | Path) -> str:
        """
        Return which of a file's cameras it is.

        Parameters
        ----------
        topics : mapping of str to str
            The cameras' keys, and the topics of their images; empty where the file names none.
        where : str or Path
            The file, to name.

        Raises
        ------
        CalibrationError
            If it is not there, or could be several; lists them.

        """
        asked = self.camera or self.topic
        found = [key for key, topic in topics.items() if asked == key or _same(asked, topic)]
        if len(found) == 1:
            return found[0]
        if len(topics) == 1 and not self.camera:
            return next(iter(topics))
        listed = ', '.join(f'{key} ({its})' if its else key for key, its in topics.items())
        if self.camera:
            raise CalibrationError(f'{where}: no camera {self.camera}, only {listed}')
        raise CalibrationError(
            f'{where}: it holds several cameras, {listed}: name one (calibration_camera in a site)'
        )


ANY = Choice()
"""The only one there is."""


def _same(topic: str, other: str) -> bool:
    """Tell whether two topics are of the same images, compressed or not."""
    one, two = (each.strip('/').removesuffix('/compressed') for each in (topic, other))
    return bool(one) and one == two
