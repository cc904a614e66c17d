"""Errors of this package; each message is one line with the file, the fault and the remedy."""


class ShirubeBagsError(ValueError):
    """Base class of the errors of shirube_bags."""


class BagError(ShirubeBagsError):
    """A bag cannot be read or written."""


class TumFileError(ShirubeBagsError):
    """A TUM trajectory file cannot be read or written."""


class TrajectoryError(ShirubeBagsError):
    """A trajectory is malformed, or two trajectories cannot be compared."""


class ReplayError(ShirubeBagsError):
    """A replay or a recording cannot be done as requested."""
