"""Errors of invalid messages and files; each text is one line with the remedy."""


class MessageError(ValueError):
    """An invalid message; the text is one line with the remedy.

    The diagnostics count messages by this text, so it contains nothing that changes from message to message.
    """


class ImageError(MessageError):
    """An image has an unsupported encoding or size, or its data is corrupted."""


class CameraInfoError(MessageError):
    """A CameraInfo is empty, does not match its image or has an unsupported distortion model."""


class PoseError(MessageError):
    """A pose or its covariance is invalid."""


class FrameError(MessageError):
    """A message is in a frame from which there is no transform."""


class PointCloudError(MessageError):
    """A point cloud lacks coordinates, is truncated, or is in an unknown frame."""


class ScanError(MessageError):
    """A laser scan has limits or angles that contradict each other."""


class CameraFileError(ValueError):
    """Base class of the file errors."""


class CalibrationError(CameraFileError):
    """A calibration cannot be read."""


class ImageFileError(CameraFileError):
    """An image cannot be read."""
