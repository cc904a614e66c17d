"""Errors of camera files; each message is one line that names file, field and remedy."""


class CameraFileError(ValueError):
    """Base class of the file errors."""


class CalibrationError(CameraFileError):
    """A calibration cannot be read."""


class ImageFileError(CameraFileError):
    """An image cannot be read."""
