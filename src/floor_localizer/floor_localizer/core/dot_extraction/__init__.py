"""Dot extraction (paper 3.1): detects the dots of an image."""

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dot_extraction.dot_image_error import DotImageError
from floor_localizer.core.dot_extraction.settings import DotDetectorSettings

__all__ = ['DotDetector', 'DotDetectorSettings', 'DotImageError']
