"""What can be wrong with a camera's files; each message is one line that names file, field and remedy."""


class CameraFileError(ValueError):
    """Root of the errors of files."""


class CalibrationError(CameraFileError):
    """A calibration cannot be read."""


class ImageFileError(CameraFileError):
    """An image cannot be read."""
