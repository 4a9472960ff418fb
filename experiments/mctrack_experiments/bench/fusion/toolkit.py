"""The shared fusion benchmark: a folder with scenes, a scorer and other trackers, not ours."""

from __future__ import annotations

import importlib
import io
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FOLDER = '../shared/bench'
WARM_UP = 25
"""First ticks that do not count."""

PARTS = ('generate', 'scenario', 'score', 'peers')

PEERS = {'norfair': 'norfair', 'stonesoup-gnn': 'stonesoup'}
"""Names in the benchmark and the packages that they need."""

SLOW_PEERS = ('stonesoup-gnn',)
"""They take so long that they are given few ticks, and no whole scene."""

INSTALL = 'pip install stonesoup==1.9.1 motpy==0.0.10 rich && pip install --no-deps norfair==2.3.0'


@dataclass(frozen=True, slots=True)
class Scene:
    """
    A scene with exact truth.

    Attributes
    ----------
    scenario : Scenario of the benchmark
        What a tracker may know, and the truth for the scorer.
    fields : mapping of str to array
        Everything that the benchmark's generator gives, by its names.

    """

    scenario: Any
    fields: Mapping[str, NDArray[Any]]


class Toolkit:
    """
    The benchmark's modules, imported from their folder.

    Parameters
    ----------
    folder : path
        Where they are.

    Raises
    ------
    OSError
        If one is missing; says how to name the folder.

    """

    def __init__(self, folder: str | Path) -> None:
        folder = Path(folder).resolve()
        for part in PARTS:
            if not (folder / f'{part}.py').is_file():
                raise OSError(
                    f'the fusion benchmark ({part}.py) is not in {folder}: '
                    'name its folder with --folder or MCTRACK_BENCH'
                )
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
        modules = map(importlib.import_module, PARTS)
        self._generate, self._scenario, self._score, self._peers = modules

    def scene(self, frames: int, seed: int, **parameters: float) -> Scene:
        """Make a scene of so many ticks; the other parameters are the generator's own."""
        settings = self._generate.SceneParameters(frames=frames, seed=seed, **parameters)
        fields = self._generate.generate_scene(settings)
        file = io.BytesIO()
        np.savez(file, **fields)
        file.seek(0)
        return Scene(self._scenario.Scenario.load(file), fields)

    def peer(self, name: str, scene: Scene) -> Any:
        """Return a new tracker of another project."""
        return self._peers.PEERS[name](scene.scenario)

    def measure(self, trackers: Mapping[str, Any], frames: int) -> dict[str, Any]:
        """Run trackers in turns; times in ms and what each reported, by tracker."""
        measured: dict[str, Any] = self._peers.measure(trackers, frames)
        return measured

    def score(self, scene: Scene, reported: Any, skip: int = WARM_UP) -> Any:
        """Hold what was reported, tick by tick but for the first, against the truth."""
        return self._score.score(scene.scenario.truth, reported, skip=skip)


def toolkit_folder(given: Path | None = None) -> Path:
    """Return where the benchmark should be: as given, as MCTRACK_BENCH says, or beside us."""
    return given or Path(os.environ.get('MCTRACK_BENCH', FOLDER))


def installed_peers() -> tuple[str, ...]:
    """Return which of the other trackers can be run here."""
    return tuple(name for name, package in PEERS.items() if find_spec(package))


def peer_version(name: str) -> str:
    """Return which version of another tracker's package is measured."""
    return f'{PEERS[name]} {version(PEERS[name])}'
