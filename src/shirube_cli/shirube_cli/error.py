"""What the command says when it cannot do what it was asked."""


class CommandError(RuntimeError):
    """A request that cannot be fulfilled; the message is one line that names the remedy."""
