"""Reserves a ROS domain that no other process on this host uses."""

from collections.abc import Iterator
from contextlib import contextmanager

from domain_coordinator import domain_id


@contextmanager
def free_domain() -> Iterator[int]:
    """Reserve a domain ID, 1 to 100, for the duration of the context.

    Errors in the context are not passed to `domain_coordinator`: it would take any OSError for a domain that is not
    free, try the next one, and hide the error behind its own.
    """
    reserved = domain_id()
    number: int = reserved.__enter__()
    try:
        yield number
    finally:
        reserved.__exit__(None, None, None)
