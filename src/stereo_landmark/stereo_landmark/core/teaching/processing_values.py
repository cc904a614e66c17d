"""Image processing settings as numbers by name, for sliders and files."""

from __future__ import annotations

from functools import reduce
from typing import Any

from shirube_core.settings import describe_settings
from stereo_landmark.core.procedure.stereo_view import ImageProcessing


def processing_values(processing: ImageProcessing) -> dict[str, float]:
    """Return all values by name, such as ``edges.threshold``."""
    names = [description.name for description in describe_settings(ImageProcessing)]
    return {name: _get_value(processing, name) for name in names}


def _get_value(settings: Any, name: str) -> float:
    return float(reduce(getattr, name.split('.'), settings))
