"""Reserves a ROS domain that no other process on this host uses."""

from collections.abc import Iterator
from contextlib import contextmanager
from secrets import randbelow

from domain_coordinator import domain_id


@contextmanager
def free_domain() -> Iterator[int]:
    """Reserve a domain ID, 1 to 100, for the duration of the context.

    It is drawn at random: in a domain that was just left, nodes of the same name would be seen for some time.
    Errors in the context are not passed to `domain_coordinator`: it would take any OSError for a domain that is not
    free, try the next one, and hide the error behind its own.
    """
    reserved = domain_id(lambda: randbelow(100) + 1)
    number: int = reserved.__enter__()
    try:
        yield number
    finally:
        reserved.__exit__(None, None, None)
