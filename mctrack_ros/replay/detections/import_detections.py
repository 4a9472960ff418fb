"""Detections of other detectors, put on the ground and into a bag like those of cameras."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import ClassCode, Detections
from mctrack_ros.perception import boxes_to_detections, positions_to_detections
from mctrack_ros.recording import BagWriter
from mctrack_ros.recording.tables.class_names import CLASS_NAMES
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tables.sightings import Sightings
from mctrack_ros.replay.detections.follow import followed
from mctrack_ros.site.site import SiteConfig

_LEFT_OUT = -1

MappingAt = Callable[[int], GroundMapping | None]
"""Gives a camera's calibration at a stamp, ns; None: nobody knows how it looked."""


@dataclass(slots=True)
class Imported:
    """
    What became of a camera's detections.

    Attributes
    ----------
    images, empty : int
        Messages written, and those of them without detections.
    rows, written : int
        Detections read, and written.
    doubtful : int
        Left out: their score is too low.
    no_ground : int
        Left out: their feet are not on the ground that the camera sees.
    lost : int
        Messages not written: nobody knows how the moving camera looked.
    outside : int
        Left out: boxes wholly outside the image.
    extrapolated : int
        Written, with more uncertainty: beyond the points of the calibration.
    classes : Counter of str
        Left out: classes that this package does not know.

    """

    images: int = 0
    empty: int = 0
    rows: int = 0
    written: int = 0
    doubtful: int = 0
    no_ground: int = 0
    lost: int = 0
    outside: int = 0
    extrapolated: int = 0
    classes: Counter[str] = field(default_factory=Counter)


def import_detections(
    sightings: Mapping[str, Sightings],
    site: SiteConfig,
    out: str | Path,
    *,
    images: str | Path | None = None,
    classes: Mapping[str, ClassCode] = CLASS_NAMES,
    least_score: float = 0.0,
    overwrite: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, Imported]:
    """
    Write detections of a site's cameras into a bag, on ``/<camera>/detections``.

    Parameters
    ----------
    sightings : mapping of str to Sightings
        By the name of the camera; positions in the coordinates of the site's files.
    site : SiteConfig
        Whose calibrations put them on the ground.
    out : str or Path
        The bag.
    images : str or Path, optional
        Bag with the images of cameras that move, which are followed in them.
    classes : mapping of str to ClassCode
        Class of each of the detectors' names, in lower case; without names all are people.
    least_score : float
        Those of a lower score, 0 to 1, are left out.
    overwrite : bool
        Whether a bag already there is replaced.
    progress : callable
        Called with images done and in all.

    Returns
    -------
    dict of str to Imported
        What became of them.

    Raises
    ------
    BagError, CalibrationError, ConfigError, TableError
        If a camera is not the site's, its calibration or the bag cannot be used, or a class is a
        number of which nobody said what it is.

    """
    local = {
        name: replace(each, position=each.position - np.array(site.origin))
        for name, each in sightings.items()
    }
    mappings = {name: _mappings_of(site, name, each, images) for name, each in local.items()}
    done = {name: Imported() for name in sightings}
    sizes = {name: (each.image_width, each.image_height) for name, each in site.cameras.items()}
    streams = [
        _messages(
            (name, sizes[name], mappings[name]),
            each,
            _codes(name, each, classes),
            done[name],
            least_score,
        )
        for name, each in local.items()
    ]
    total = sum(len(each.stamp_ns) for each in sightings.values())
    with BagWriter(out, overwrite=overwrite) as bag:
        merged = heapq.merge(*streams, key=lambda item: (item[1].stamp_ns, item[0]))
        for count, (name, rows) in enumerate(merged, 1):
            bag.write_rows(f'/{name}/detections', rows, site.ground_frame)
            progress(count, total)
    return done


def _mappings_of(
    site: SiteConfig, camera: str, sightings: Sightings, images: str | Path | None
) -> MappingAt:
    """Return what gives a camera's calibration at a stamp; raise `TableError` for an unknown."""
    if camera not in site.cameras:
        raise TableError(
            f'{camera} is no camera of the site {site.name}: they are '
            f'{", ".join(site.camera_names)}'
        )
    settings = site.cameras[camera]
    if not settings.pipeline.moves:
        mapping = settings.mapping()
        return lambda stamp_ns: mapping
    if images is None:
        raise TableError(f'{camera} moves: name the bag with its images, --images')
    return followed(camera, settings, images, sightings).get


def _codes(
    camera: str, sightings: Sightings, classes: Mapping[str, ClassCode]
) -> NDArray[np.int64]:
    """Return the class of each row, (n,); `_LEFT_OUT` of those that are not known."""
    labels, which = np.unique(sightings.label, return_inverse=True)
    for label in labels.tolist():
        if label.isdigit() and label not in classes:
            raise TableError(
                f'{camera}: class {label} is a number: say what it is, --class {label}=person'
            )
    names = [label.lower() or 'person' for label in labels.tolist()]
    known = [int(classes.get(name, _LEFT_OUT)) for name in names]
    return np.array([*known, _LEFT_OUT], np.int64)[which]


def _messages(
    camera: tuple[str, tuple[int, int], MappingAt],
    sightings: Sightings,
    code: NDArray[np.int64],
    done: Imported,
    least_score: float,
) -> Iterator[tuple[str, Detections]]:
    """Yield the detections of each image; count used and refused rows."""
    stranger = code == _LEFT_OUT
    done.classes.update(sightings.label[stranger].tolist())
    (name, size, mapping_at), box = camera, sightings.box
    outside = ((box[:, :2] > np.array(size)) | (box[:, :2] + box[:, 2:] < 0)).any(
        axis=1
    ) & ~stranger
    doubtful = (sightings.score < least_score) & ~stranger & ~outside
    done.outside, done.doubtful = int(outside.sum()), int(doubtful.sum())
    done.rows = len(sightings)
    usable = ~(stranger | outside | doubtful)
    bounds = np.searchsorted(sightings.image, np.arange(len(sightings.stamp_ns) + 1))
    for stamp_ns, start, stop in zip(sightings.stamp_ns.tolist(), bounds, bounds[1:]):
        row, mapping = np.arange(start, stop)[usable[start:stop]], mapping_at(stamp_ns)
        if mapping is None:
            done.lost += 1
            continue
        detections = _located(sightings, row, code[row], mapping, stamp_ns)
        feet = detections.box[:, :2] + detections.box[:, 2:] * np.array([0.5, 1.0])
        boxed = detections.box[:, 2] > 0
        done.extrapolated += int(mapping.is_extrapolated(feet[boxed]).sum()) if boxed.any() else 0
        done.no_ground += len(row) - len(detections)
        done.written += len(detections)
        done.images += 1
        done.empty += int(not len(detections))
        yield name, detections


def _located(
    sightings: Sightings,
    row: NDArray[np.intp],
    code: NDArray[np.int64],
    mapping: GroundMapping,
    stamp_ns: int,
) -> Detections:
    """Return the detections of some rows; a position takes precedence over a box."""
    placed = np.isfinite(sightings.position[row, 0])
    at, boxed = row[placed], row[~placed]
    parts = [
        positions_to_detections(
            sightings.position[at], sightings.score[at], mapping, stamp_ns, sightings.sigma[at],
            class_id=code[placed], local_id=sightings.local_id[at],
        ),
        boxes_to_detections(
            sightings.box[boxed], sightings.score[boxed], mapping, stamp_ns,
            class_id=code[~placed], local_id=sightings.local_id[boxed],
        ),
    ]  # fmt: skip
    return Detections.joined(stamp_ns, [part for part in parts if len(part)])
