"""Read a calibration given as a matrix: a homography or a projection."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.homography.projective import ProjectiveMapping, inverted
from mctrack_ros.ground.yaml_files import read_yaml_file

_SHAPES = {'image_from_ground': (3, 3), 'ground_from_image': (3, 3), 'image_from_world': (3, 4)}


class ProjectionError(CalibrationError):
    """A projection file that cannot be used; names the file and the reason."""


def holds_projection(content: Mapping[str, Any]) -> bool:
    """Tell whether the content of a YAML file is a matrix that `read_projection` takes."""
    return any(name in content for name in _SHAPES)


def read_projection(
    path: str | Path, image_size: tuple[int, int], metres_per_unit: float = 1.0
) -> ProjectiveMapping:
    """
    Read a YAML file that holds one matrix, as a list of rows.

    Parameters
    ----------
    path : str or Path
        The file. Its one key names the matrix: ``image_from_ground`` or ``ground_from_image``,
        3 x 3, or ``image_from_world``, 3 x 4; pixels and metres or another unit.
    image_size : (int, int)
        Width and height of the image the matrix belongs to, px.
    metres_per_unit : float
        What a unit of length of the file is.

    Raises
    ------
    ProjectionError
        If the file cannot be read or does not hold exactly one such matrix.

    """
    content = read_yaml_file(path, ProjectionError)
    if not isinstance(content, dict) or len(content) != 1 or not content.keys() <= _SHAPES.keys():
        raise ProjectionError(f'{path}: expected exactly one of the keys {sorted(_SHAPES)}')
    ((name, rows),) = content.items()
    try:
        matrix: NDArray[np.float64] = np.asarray(rows, np.float64)
        if matrix.shape != _SHAPES[name]:
            raise ValueError(f'{name} has shape {matrix.shape}, expected {_SHAPES[name]}')
        if name == 'ground_from_image':
            matrix = inverted(matrix)
        matrix[:, :-1] /= metres_per_unit
        if name == 'image_from_world':
            return _checked(ProjectiveMapping(matrix, image_size))
        return ProjectiveMapping.from_homography(matrix, image_size)
    except np.linalg.LinAlgError as error:
        raise ProjectionError(
            f'{path}: {name} is singular: it takes the ground to a line, so some of its numbers '
            'are wrong or were left out'
        ) from error
    except (ValueError, TypeError) as error:
        raise ProjectionError(f'{path}: {error}') from error


def _checked(mapping: ProjectiveMapping) -> ProjectiveMapping:
    """Refuse a world that is mirrored; one below which the camera is, is left to others."""
    if mapping.camera_position[2] > 0 and np.linalg.det(mapping.image_from_world[:, :3]) < 0:
        raise ValueError(
            'the world would be mirrored: is the sign of one axis wrong, are two of them swapped, '
            'or does the camera look into the sky?'
        )
    return mapping


def write_projection(mapping: ProjectiveMapping, name: str, path: str | Path) -> None:
    """
    Write one matrix of a mapping as a YAML file, metres and pixels.

    Parameters
    ----------
    mapping : ProjectiveMapping
        The mapping.
    name : str
        Which matrix: ``image_from_ground``, ``ground_from_image`` or ``image_from_world``.
    path : str or Path
        The file.

    """
    matrix = {
        'image_from_ground': mapping.image_from_ground_homography,
        'ground_from_image': mapping.ground_from_image_homography,
        'image_from_world': mapping.image_from_world,
    }[name]
    rows = ''.join(f'  - {row}\n' for row in matrix.tolist())
    Path(path).write_text(f'{name}:\n{rows}', encoding='utf-8')
