"""Messages that a node cannot use: the errors of this package."""


class MessageError(ValueError):
    """A message cannot be used; the text is one clear line with the remedy.

    The text is also the reason under which diagnostics count the message, so it holds nothing that changes
    from message to message.
    """


class ImageError(MessageError):
    """An image has a wrong encoding or size, or its data is broken."""


class CameraInfoError(MessageError):
    """A CameraInfo is empty, contradicts its image or has an unknown distortion model."""


class PoseError(MessageError):
    """A pose or its covariance holds numbers that no pose has."""


class PointCloudError(MessageError):
    """A point cloud lacks coordinates, is cut off, or lies in a frame that is not known."""
