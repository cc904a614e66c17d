"""The message types of ROS 2 Jazzy as dataclasses, without a ROS installation."""

from __future__ import annotations

from functools import lru_cache

from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore


@lru_cache(maxsize=1)
def jazzy_types() -> Typestore:
    """Return the common interfaces of ROS 2 Jazzy.

    ``jazzy_types().types['geometry_msgs/msg/PoseStamped']`` is the dataclass of that message; its arrays of
    numbers are numpy arrays. The store is shared: do not register types in it.
    """
    return get_typestore(Stores.ROS2_JAZZY)
