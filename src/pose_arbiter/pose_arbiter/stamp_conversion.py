"""Conversion of stamps to integer nanoseconds, without loss."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time


def nanoseconds(stamp: Any) -> int:
    """Return the stamp of a message [ns]."""
    return int(stamp.sec * 1_000_000_000 + stamp.nanosec)


def time_message(stamp: int) -> Time:
    """Return a stamp [ns] as a message."""
    sec, nanosec = divmod(stamp, 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)
