"""The image processing as numbers by name, as sliders and files have them."""

from __future__ import annotations

from functools import reduce

from shirube_settings import describe_settings
from stereo_landmark.core.procedure.detected_scene import ImageProcessing


def processing_values(processing: ImageProcessing) -> dict[str, float]:
    """Return all numbers, named as ``edges.threshold``."""
    return {
        description.name: reduce(getattr, description.name.split('.'), processing)
        for description in describe_settings(ImageProcessing)
    }
