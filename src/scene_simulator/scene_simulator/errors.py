"""The one exception root of the simulator."""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be built; the message is one line with the reason."""


def check_seed(seed: int) -> None:
    """Refuse a seed that no generator takes.

    Raises:
        SceneError: a negative seed.
    """
    if seed < 0:
        raise SceneError(f'the seed is {seed}: give zero or a positive whole number')
