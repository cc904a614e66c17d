"""Loads rclpy message classes by name."""

from __future__ import annotations

import importlib
from typing import Any

from shirube_bags.errors import ReplayError


def load_message_class(msgtype: str) -> Any:
    """Return the class of a message type such as ``sensor_msgs/msg/Image``.

    Raises:
        ReplayError: the type is not installed.
    """
    package, _, name = msgtype.partition('/msg/')
    try:
        return getattr(importlib.import_module(f'{package}.msg'), name)
    except (ImportError, AttributeError, TypeError, ValueError) as fault:
        raise ReplayError(
            f'the message type {msgtype} is not installed; install its package {package}'
        ) from fault
