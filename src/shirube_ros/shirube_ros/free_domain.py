"""A ROS domain that no other process of this machine uses."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from domain_coordinator import domain_id


@contextmanager
def free_domain() -> Iterator[int]:
    """Give the number of a domain, 1 to 100, that stays ours to the end.

    What fails in its scope is not told to `domain_coordinator`, which would take any OSError for a domain that is not
    free, try the next one, and hide the error behind one of its own.
    """
    reserved = domain_id()
    number: int = reserved.__enter__()
    try:
        yield number
    finally:
        reserved.__exit__(None, None, None)
