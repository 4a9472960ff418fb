"""What a site says of one camera: its images, its calibration, its pipeline."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.ground import (
    METHODS,
    METRES,
    CalibrationError,
    Choice,
    GroundMapping,
    first_look,
    holds_camera,
    mapping_from_grid,
    read_calibration,
    read_camera,
    read_grid,
)
from mctrack_ros.ground.yaml_files import read_yaml_file
from mctrack_ros.input_size import IMAGE, check_size
from mctrack_ros.perception import CAMERA, CameraConfig, CameraTracker, Given, open_camera
from mctrack_ros.site.origin import check_near
from mctrack_ros.site.stated_origin import origin_from


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """One camera: its images, its calibration, its pipeline."""

    image_topic: str = parameter(
        'image_raw/compressed',
        'topic of images, below the name of the camera; with a leading slash a whole name. One '
        'that ends in /compressed holds JPEG or PNG',
    )
    boxes_topic: str = parameter(
        '',
        'topic of boxes, named likewise, which a live node takes in place of images; empty: none',
    )
    boxes_type: str = parameter(
        'Detection2DArray',
        'message of boxes_topic; a cloud has box and score',
        choices=('Detection2DArray', 'PointCloud2'),
    )
    image_width: int = parameter(768, 'width of the images [px]', minimum=16, maximum=16384)
    image_height: int = parameter(576, 'height of the images [px]', minimum=16, maximum=16384)
    grid: str = parameter('', 'transformation-grid XML file')
    method: str = parameter('fitted', 'how the grid maps pixels to metres', choices=METHODS)
    click_noise_px: float = parameter(
        0.5, "standard deviation of the grid's pixels along one axis [px]", minimum=0.0
    )
    calibration: str = parameter(
        '',
        'calibration file instead of a grid: of ROS, OpenCV, Kalibr or Tsai, or a matrix',
    )
    calibration_camera: str = parameter(
        '', 'camera in a calibration file of several: its key there (cam1), or its topic'
    )
    extrinsics: str = parameter('', "file with the camera's pose, if the calibration has none")
    length_unit: str = parameter('m', 'unit of lengths in the calibration', choices=tuple(METRES))
    origin: str = parameter(
        '0,0',
        "x,y of the site's local origin, in the coordinates of the calibration: detections are "
        'relative to it [m]',
    )
    clock_offset: float = parameter(
        0.0,
        "by how much the camera's clock is ahead of the others', which is taken from its stamps; "
        'mctrack doctor --clocks measures it [s]',
        minimum=-10.0,
        maximum=10.0,
    )
    mask: str = parameter('', 'image whose black pixels are ignored; empty: none')
    background: str = parameter(
        '', 'image without moving objects; empty: the background is learned first'
    )
    lines: str = parameter(
        '',
        'YAML file with the lines painted on the ground, each a list of x,y in m: a camera that '
        'pans, tilts and zooms is pulled back to them; empty: none',
    )
    pipeline: CameraConfig = CAMERA.field()

    def open(self, name: str, background: NDArray[np.uint8] | None = None) -> CameraTracker:
        """
        Read the camera's files and return its tracker.

        Parameters
        ----------
        name : str
            Of the camera.
        background : (h, w, 3) uint8 array, optional
            Image without moving objects, where the settings name none.

        Raises
        ------
        ConfigError, CalibrationError
            If a file cannot be used.

        """
        mask = self.ignore_mask()
        if self.background:
            background = self._image('background', cv2.IMREAD_COLOR)
        given = Given(name, self.mapping(), mask, background, self.painted_lines())
        return open_camera(self.pipeline, given)

    def painted_lines(self) -> list[NDArray[np.float64]]:
        """
        Read the lines painted on the ground, (n, 2) polylines, m, relative to the site's origin.

        Raises
        ------
        ConfigError
            If the file cannot be read or holds something else.

        """
        if not self.lines:
            return []
        content = read_yaml_file(self.lines, ConfigError)
        try:
            lines = [np.asarray(line, np.float64) for line in content]
            wrong = [
                line for line in lines if line.shape[1:] != (2,) or not np.isfinite(line).all()
            ]
        except (TypeError, ValueError) as error:
            raise ConfigError(f'{self.lines}: expected lists of points x, y: {error}') from error
        if wrong:
            raise ConfigError(
                f'{self.lines}: expected lists of points x, y, got {wrong[0].tolist()}'
            )
        return [line - origin_from(self.origin) for line in lines]

    def mapping(self) -> GroundMapping:
        """
        Read the calibration, relative to the site's origin.

        Raises
        ------
        ConfigError
            If neither a grid nor a calibration is named, or both, or it is far from the origin.
        CalibrationError
            If the file cannot be used.

        """
        mapping, origin = self.stated_mapping(), origin_from(self.origin)
        check_near(mapping.camera_position[:2], origin, self.grid or self.calibration)
        return mapping.moved(np.negative(origin))

    @property
    def ahead_ns(self) -> int:
        """By how much the camera's clock is ahead, in whole milliseconds, ns."""
        return round(self.clock_offset * 1e3) * 1_000_000

    def place(self) -> NDArray[np.float64]:
        """Return where the camera is, (2,) m, in the calibration's coordinates; raises alike."""
        if self.grid and not self.calibration:
            return np.asarray(np.median(read_grid(self.grid).points()[0], axis=0), np.float64)
        return self.stated_mapping().camera_position[:2]

    def stated_mapping(self) -> GroundMapping:
        """
        Read the calibration, positions in its own coordinates.

        Raises
        ------
        ConfigError
            If neither a grid nor a calibration is named, or both.
        CalibrationError
            If the file cannot be used.

        """
        size = (self.image_width, self.image_height)
        if bool(self.grid) == bool(self.calibration):
            raise ConfigError('name either a grid or a calibration file of the camera')
        if self.calibration:
            return read_calibration(
                self.calibration, size, self.extrinsics, self.length_unit, self._choice()
            )
        grid = read_grid(self.grid)
        try:
            return mapping_from_grid(grid, size, self.method, self.click_noise_px)
        except CalibrationError as error:
            raise type(error)(f'{self.grid}: {error}') from error

    def doubt(self) -> str:
        """
        Return why the calibration is to be doubted; empty: it is not.

        Of a camera fitted to a grid a first look, quick enough for a start (`mctrack
        check-calibration` looks closer); of other files, what they state and is left out.

        Raises
        ------
        CalibrationError
            If the file cannot be read.

        """
        size = (self.image_width, self.image_height)
        if self.grid and self.method == 'fitted':
            return first_look(read_grid(self.grid), size, self.click_noise_px)
        if self.calibration and holds_camera(self.calibration):
            notes = read_camera(self.calibration, size, choice=self._choice()).notes
            return '; '.join(notes)
        return ''

    def _choice(self) -> Choice:
        return Choice(self.calibration_camera, self.image_topic)

    def ignore_mask(self) -> NDArray[np.uint8] | None:
        """
        Read the mask, (height, width) uint8 with 0 where the image is ignored.

        Raises
        ------
        ConfigError
            If the file is no image or has another size than the camera's.

        """
        return self._image('mask', cv2.IMREAD_GRAYSCALE) if self.mask else None

    def _image(self, key: str, mode: int) -> NDArray[np.uint8]:
        """Read the image that a key names, of the camera's size."""
        path = getattr(self, key)
        if not Path(path).is_file():
            raise ConfigError(f'{key} {path} does not exist')
        check_size(path, IMAGE, ConfigError)
        image = cv2.imread(path, mode)
        if image is None:
            raise ConfigError(f'{key} {path} is no image that OpenCV reads')
        height, width = image.shape[:2]
        if (width, height) != (self.image_width, self.image_height):
            raise ConfigError(
                f'{key} {path} is {width} x {height}, expected '
                f'{self.image_width} x {self.image_height}'
            )
        return np.asarray(image, np.uint8)
