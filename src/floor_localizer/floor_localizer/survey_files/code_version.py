"""Version of the survey code: a checkpoint can only be resumed by the version that wrote it."""

from __future__ import annotations

import hashlib
from pathlib import Path

import cv2
import numba
import numpy as np
import scipy

import floor_localizer.core
import floor_localizer.survey_files
import shirube_core.geometry

_PACKAGES = (floor_localizer.core, floor_localizer.survey_files, shirube_core.geometry)
_LIBRARIES = (cv2, numba, np, scipy)


def code_version() -> str:
    """Return a version from the hash of all sources used by a survey and the versions of its numerical libraries.

    It changes without manual bumping, and therefore also with changes that do not affect the results.
    """
    digest = hashlib.sha256()
    for package in _PACKAGES:
        folder = Path(package.__path__[0])
        for source in sorted(folder.rglob('*.py')):
            digest.update(f'{package.__name__}/{source.relative_to(folder)}\n'.encode())
            digest.update(source.read_bytes())
    libraries = ', '.join(f'{library.__name__} {library.__version__}' for library in _LIBRARIES)
    return f'sources {digest.hexdigest()[:16]}, {libraries}'
