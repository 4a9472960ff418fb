"""A site and its calibrations as a few files that can travel in a bag."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from mctrack_ros.config import ConfigError
from mctrack_ros.ground.yaml_files import read_yaml_file
from mctrack_ros.site.site import FILES

FOLDER = 'mctrack/site'
"""Where they lie among the attachments of a bag."""
SITE_FILE = 'site.yaml'


def portable_site(path: str | Path) -> dict[str, bytes]:
    """
    Return a site YAML and the files that its cameras name, by the names of attachments.

    Names of files in it are changed to where they lie beside it; what cannot be read is left out,
    and of a private site the backgrounds, which are pictures.

    Parameters
    ----------
    path : str or Path
        The site YAML.

    Raises
    ------
    ConfigError
        If it cannot be read.

    """
    path = Path(path)
    content: Any = read_yaml_file(path, ConfigError)
    found: dict[str, bytes] = {}
    for name, camera in _mapping(content.get('cameras')).items():
        for key in FILES:
            named = camera.get(key) if isinstance(camera, dict) else None
            if named and key == 'background' and content.get('private'):
                del camera[key]
                continue
            file = path.parent / str(named)
            if named and file.is_file():
                inside = f'{name}/{key}{file.suffix}'
                found[f'{FOLDER}/{inside}'] = file.read_bytes()
                camera[key] = inside
    text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    return {f'{FOLDER}/{SITE_FILE}': text.encode(), **found}


def unpack_site(attachments: Mapping[str, bytes], folder: Path) -> Path | None:
    """Write the site that is attached to a bag into a folder; return its YAML, None: none is."""
    for name, data in attachments.items():
        place = (folder / name.removeprefix(f'{FOLDER}/')).resolve()
        if name.startswith(f'{FOLDER}/') and place.is_relative_to(folder.resolve()):
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)
    path = folder / SITE_FILE
    return path if path.exists() else None


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}
