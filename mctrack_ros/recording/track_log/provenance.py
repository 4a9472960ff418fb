"""Versions and processor features on which floating-point results may depend."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from mctrack_ros import __version__

_PACKAGES = ('numpy', 'scipy', 'numba', 'llvmlite', 'opencv-python-headless')


@cache
def provenance() -> Mapping[str, str]:
    """Return versions by package, and the processor's features that NumPy uses."""
    made_by = {'mctrack_ros': __version__, 'python': platform.python_version()}
    for package in _PACKAGES:
        try:
            made_by[package] = version(package)
        except PackageNotFoundError:
            continue
    made_by['processor'] = ' '.join([platform.machine(), *_features()])
    return made_by


def differences(there: Mapping[str, Any], here: Mapping[str, str]) -> list[str]:
    """Return what differs between two provenances, a text each; of what one lacks, nothing."""
    texts = []
    for name in sorted(there.keys() & here.keys()):
        if name == 'processor':
            stated, own = set(str(there[name]).split()), set(here[name].split())
            texts += [f'processor: {each} there, not here' for each in sorted(stated - own)]
            texts += [f'processor: {each} here, not there' for each in sorted(own - stated)]
        elif there[name] != here[name]:
            texts.append(f'{name} {there[name]} there, {here[name]} here')
    return texts


def _features() -> list[str]:
    """Return the processor's features, as NumPy names them; it has no public list."""
    for name in ('numpy._core._multiarray_umath', 'numpy.core._multiarray_umath'):
        try:
            known: Mapping[str, bool] = import_module(name).__cpu_features__
        except (ImportError, AttributeError):
            continue
        return sorted(feature for feature, is_there in known.items() if is_there)
    return []
