"""The errors of this package: one clear line each, with the file, what is wrong and the remedy."""


class ShirubeBagsError(ValueError):
    """Root of the errors of shirube_bags."""


class BagError(ShirubeBagsError):
    """A bag cannot be read or written."""


class TumFileError(ShirubeBagsError):
    """A TUM trajectory file cannot be read or written."""


class TrajectoryError(ShirubeBagsError):
    """A trajectory is malformed, or two trajectories cannot be compared."""


class ReplayError(ShirubeBagsError):
    """A replay or a recording cannot do what was asked of it."""
