"""A site: one YAML that names the cameras, their calibrations and the settings of every part."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely.affinity
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError, config_from, of_chosen, parameter, values_of
from mctrack_ros.fusion import FUSION, FusionConfig, Views, fusion_method
from mctrack_ros.ground import CalibrationError
from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.ground.yaml_files import read_yaml_file
from mctrack_ros.interfaces import MAX_CAMERAS, Detections, Tracks
from mctrack_ros.perception import CAMERA, camera_method
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.description import offline_run, site_description
from mctrack_ros.site.names import check_camera_name
from mctrack_ros.site.origin import check_zones_near, chosen_origin
from mctrack_ros.site.plan import PITCH, FloorPlan, floor_plan
from mctrack_ros.site.stated_origin import Origin, origin_from, origin_text
from mctrack_ros.zones.files import BLOCKS, zones_from
from mctrack_ros.zones.shapes import Zones

FILES = ('grid', 'calibration', 'extrinsics', 'mask', 'background', 'lines')
"""Parameters of a camera that name files."""


@dataclass(frozen=True, slots=True)
class SiteConfig:
    """
    A whole site.

    Attributes
    ----------
    name : str
        Of the site.
    ground_frame : str
        ``frame_id`` of everything on the ground.
    feedback_delay : float
        Age of the feedback that a camera uses, s.
    area : str
        What is to be covered, as `area_from` of `mctrack_ros.ground.coverage` reads it; may be
        empty.
    cameras : dict of str to CameraSettings
        By name, in the order of the camera bits: sorted.
    fusion : FusionConfig
        Of the fusion node.
    origin : (float, float)
        Origin of positions inside and on topics, in the coordinates of the site's files,
        m.
    path : str
        Of the file that it was read from; may be empty.
    names_tracker : bool
        Whether it says by what it is tracked; see `mctrack_ros.site.choice`.
    zones : Zones
        Its zones and lines, in the coordinates of the site's files.
    geo : str
        Where on the earth it lies, as `GeoReference` of `mctrack_ros.streams` reads it.
    is_pitch : bool
        Whether it is a football pitch, its origin in a corner.
    floor_plan : FloorPlan or None
        An image of its floor.
    private : bool
        Whether no picture leaves the camera nodes or enters a bag.
    blur : bool
        Whether people in debug images are made unrecognisable.
    cells : tuple of str
        Namespaces of other fusion nodes, whose tracks it fuses; then it has no cameras.

    """

    name: str
    ground_frame: str
    feedback_delay: float
    area: str
    cameras: Mapping[str, CameraSettings]
    fusion: FusionConfig
    origin: Origin = (0.0, 0.0)
    path: str = ''
    names_tracker: bool = True
    zones: Zones = Zones()
    geo: str = ''
    is_pitch: bool = False
    floor_plan: FloorPlan | None = None
    private: bool = False
    blur: bool = True
    cells: tuple[str, ...] = ()

    @property
    def camera_names(self) -> tuple[str, ...]:
        """Names of the cameras, or else of the cells, in the order of the camera bits."""
        return self.cells or tuple(self.cameras)

    @property
    def own_zones(self) -> Zones:
        """Zones and lines relative to the origin, as positions on topics are."""
        x, y = self.origin
        return self.zones.moved((-x, -y))

    @property
    def clock_offsets(self) -> dict[str, float]:
        """By how much the clocks of cameras are ahead, s, where that is stated."""
        return {name: own.clock_offset for name, own in self.cameras.items() if own.ahead_ns}

    @property
    def image_sizes(self) -> dict[str, tuple[int, int]]:
        """Width and height of each camera's images, px."""
        return {name: (own.image_width, own.image_height) for name, own in self.cameras.items()}

    def views(self) -> Views:
        """
        Read the cameras' calibrations, relative to the site's origin.

        Raises
        ------
        ConfigError, CalibrationError
            If a calibration cannot be read.

        """
        area = (
            shapely.affinity.translate(area_from(self.area), *np.negative(self.origin))
            if self.area
            else None
        )
        return Views({name: camera.mapping() for name, camera in self.cameras.items()}, area)

    def values(self) -> dict[str, Any]:
        """Return all settings as plain values, files by their bare names."""
        return {
            'name': self.name,
            'ground_frame': self.ground_frame,
            'cameras': {name: _without_paths(camera) for name, camera in self.cameras.items()},
            **({'cells': list(self.cells)} if self.cells else {}),
            'feedback_delay': self.feedback_delay,
            'origin': list(self.origin),
            'fusion': values_of(self.fusion),
            **self.own_zones.configured(),
            'clock_offsets': self.clock_offsets,
            **({'private': True} if self.private else {}),
        }

    def description(self, began_ns: int) -> str:
        """Return what `/site` says of a run over a recording, by the stamp of its first tick."""
        values = self.values()
        run = offline_run(values, began_ns)
        return site_description(values, list(self.cameras), run, self.image_sizes)


@dataclass(frozen=True, slots=True)
class SiteScalars:
    """The keys of a site YAML beside its cameras and what they share."""

    name: str = parameter('site', 'name of the site')
    ground_frame: str = parameter('map', 'frame_id of positions on the ground')
    feedback_delay: float = parameter(
        0.0,
        'age of the feedback that a camera uses; 0: two periods of fusion.batching [s]',
        minimum=0.0,
        maximum=10.0,
    )
    area: str = parameter(
        '',
        'what the cameras are to cover: x0,y0,x1,y1 or the corners x,y of a polygon; '
        'empty: the rectangle around all that they see [m]',
    )
    origin: str = parameter(
        '',
        'x,y of the origin of positions inside and on topics, in the coordinates of the '
        "site's files; empty: 0,0, or whole kilometres near cameras that are far from it [m]",
    )
    geo: str = parameter(
        '',
        'latitude,longitude of the origin of positions and, third, where the y axis points to, '
        'clockwise from north, for streams of ONVIF metadata; empty: not known [degrees]',
    )
    plan: str = parameter(
        '',
        'what the map shows: pitch, or an image of the floor and the corners that it covers, for '
        'example floor.png 0,0,40,25 [m]',
    )
    private: bool = parameter(
        False, 'no picture leaves a camera node or enters a bag, and none is written for debugging'
    )
    blur: bool = parameter(True, 'make people in debug images unrecognisable')
    fusion: FusionConfig = FUSION.field()


def load_site(path: str | Path) -> SiteConfig:
    """
    Read and check a site YAML; paths in it are relative to the file.

    Raises
    ------
    ConfigError
        If the file cannot be read, a key is unknown or a value wrong; names file and key.

    """
    path = Path(path)
    content = read_yaml_file(path, ConfigError)
    try:
        return dataclasses.replace(site_from(content, path.parent), path=str(path.resolve()))
    except ConfigError as error:
        raise ConfigError(f'{path}: {error}') from error


def site_from(content: Any, directory: Path) -> SiteConfig:
    """
    Build a site from nested values.

    Parameters
    ----------
    content : object
        A mapping with ``name``, ``ground_frame``, ``feedback_delay``, ``area``, ``origin``,
        ``plan``, ``private``, ``blur``, ``fusion``, ``zones``, ``lines``, ``cameras`` and
        ``pipeline``, the settings that all cameras share; or with ``cells`` in place of both.
    directory : Path
        What paths are relative to.

    Raises
    ------
    ConfigError
        If a key is unknown or a value wrong; says which.

    """
    if not isinstance(content, Mapping):
        raise ConfigError('expected a mapping with the key cameras')
    values = dict(content)
    cells = _cells(values)
    cameras, shared = values.pop('cameras', {}), values.pop('pipeline', {})
    if not cells and not (isinstance(cameras, Mapping) and cameras):
        raise ConfigError('cameras is missing or empty: name at least one camera')
    zones = zones_from({block: values.pop(block, None) for block in BLOCKS})
    names_tracker = FUSION.tag in _mapping(values.get('fusion'))
    scalars = config_from(SiteScalars, values)
    settings = _cameras(cameras, shared, directory)
    _check_messages(settings, scalars.fusion, bool(cells))
    stated = scalars.origin
    origin = origin_from(stated) if stated else chosen_origin(_places(settings.values()))
    check_zones_near(zones, origin)
    area = _corners(scalars.area, origin)
    return SiteConfig(
        name=scalars.name,
        ground_frame=scalars.ground_frame,
        feedback_delay=scalars.feedback_delay or 2 * scalars.fusion.batching.period,
        area=scalars.area,
        cameras={
            name: dataclasses.replace(
                camera, origin=origin_text(origin), pipeline=camera.pipeline.within(area)
            )
            for name, camera in settings.items()
        },
        fusion=scalars.fusion,
        origin=origin,
        names_tracker=names_tracker,
        zones=zones,
        geo=scalars.geo,
        is_pitch=scalars.plan == PITCH,
        floor_plan=floor_plan(scalars.plan, directory),
        private=scalars.private,
        blur=scalars.blur,
        cells=cells,
    )


def _cameras(
    cameras: Mapping[str, Any], shared: Any, directory: Path
) -> dict[str, CameraSettings]:
    """Return the settings of cameras, sorted by name; `shared` are those of all pipelines."""
    if not isinstance(shared, Mapping):
        raise ConfigError(f'pipeline is {shared!r}, expected a mapping')
    if len(cameras) > MAX_CAMERAS:
        raise ConfigError(f'{len(cameras)} cameras, expected at most {MAX_CAMERAS}')
    settings = {}
    for name in sorted(cameras):
        check_camera_name(name)
        own = cameras[name]
        if not isinstance(own, Mapping):
            raise ConfigError(f'cameras.{name} is {own!r}, expected a mapping')
        merged = dict(own) | {'pipeline': _pipeline(shared, own.get('pipeline', {}))}
        if 'origin' in merged:
            raise ConfigError(f'cameras.{name}.origin: the origin is one for the whole site')
        camera = config_from(CameraSettings, merged, f'cameras.{name}.')
        settings[name] = _with_paths(camera, directory)
    return settings


def _cells(values: dict[str, Any]) -> tuple[str, ...]:
    """Take the namespaces of cells out of a site, which then fuses them; sorted as cameras are."""
    names = values.pop('cells', None)
    if names is None:
        return ()
    if values.get('cameras') is not None or values.get('pipeline'):
        raise ConfigError(
            'a site has cells, or cameras and pipeline, not both: remove one of them'
        )
    if not isinstance(names, list) or not names:
        raise ConfigError(f'cells is {names!r}, expected a list of the namespaces of cells')
    for name in names:
        check_camera_name(name)
    if len(set(names)) < len(names) or len(names) > MAX_CAMERAS:
        raise ConfigError(f'cells is {names!r}, expected at most {MAX_CAMERAS} different names')
    values['cameras'], given = {}, values.get('fusion', {})
    if isinstance(given, Mapping):
        values['fusion'] = {FUSION.tag: 'cells', **given}
    return tuple(sorted(names))


def _check_messages(
    cameras: Mapping[str, CameraSettings], fusion: FusionConfig, has_cells: bool
) -> None:
    """Refuse cameras, or cells, that do not publish what the tracker of fusion takes."""
    wanted = fusion_method(fusion).messages
    if has_cells is not (Tracks in wanted):
        given, other = ('cells', 'cameras') if has_cells else ('cameras', 'cells')
        raise ConfigError(f'fusion.tracker {fusion.tracker} takes {other}, the site has {given}')
    for name, camera in cameras.items():
        published = camera_method(camera.pipeline).messages
        if not set(wanted) <= set(published):
            topics, taken = (
                ' and '.join(kind.TOPIC for kind in kinds) for kinds in (published, wanted)
            )
            raise ConfigError(
                f'cameras.{name}.pipeline.local_tracker is {camera.pipeline.local_tracker}, which '
                f'publishes {topics}; fusion.tracker {fusion.tracker} takes {taken}'
            )
        if camera.boxes_topic and wanted != (Detections,):
            taken = ' and '.join(kind.TOPIC for kind in wanted)
            raise ConfigError(
                f'cameras.{name}.boxes_topic gives {Detections.TOPIC} alone; fusion.tracker '
                f'{fusion.tracker} takes {taken}: name joint'
            )


def _corners(area: str, origin: Origin) -> str:
    """Return the corners ``x0,y0,x1,y1`` about an area, told from an origin, m; empty: none."""
    if not area:
        return ''
    try:
        corners = np.reshape(area_from(area).bounds, (2, 2)) - origin
    except FieldOfViewError as error:
        raise ConfigError(str(error)) from error
    return ','.join(f'{value!r}' for value in corners.ravel().tolist())


def _places(cameras: Iterable[CameraSettings]) -> Iterator[NDArray[np.float64]]:
    """Yield where cameras are; of one that cannot be read, its reader says why when it is used."""
    for camera in cameras:
        with suppress(ConfigError, CalibrationError):
            yield camera.place()


def _with_paths(camera: CameraSettings, directory: Path) -> CameraSettings:
    """Return the settings with their file names made absolute."""
    files: dict[str, Any] = {
        name: str((directory / getattr(camera, name)).resolve()) if getattr(camera, name) else ''
        for name in FILES
    }
    return dataclasses.replace(camera, **files)


def _without_paths(camera: CameraSettings) -> dict[str, Any]:
    """Return the settings with bare file names: the same on every machine."""
    files = {name: Path(getattr(camera, name)).name for name in FILES}
    return values_of(camera) | files


def _pipeline(shared: Mapping[str, Any], own: Any) -> Any:
    """Return a camera's own settings laid over the shared ones; of another tracker's, none."""
    tracker = own.get(CAMERA.tag) if isinstance(own, Mapping) else None
    if isinstance(tracker, str) and tracker in CAMERA.methods:
        shared = of_chosen(CAMERA, {**shared, CAMERA.tag: tracker})
    return _merged(shared, own)


def _merged(shared: Mapping[str, Any], own: Any) -> Any:
    """Return nested mappings laid over one another; what is not a mapping replaces."""
    if not isinstance(own, Mapping):
        return own
    return dict(shared) | {
        key: _merged(_mapping(shared.get(key)), value) for key, value in own.items()
    }


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}
