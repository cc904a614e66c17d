"""Stands for tf2_ros and tf2_msgs, which have no wheels: transforms in memory, and publishers that only record."""

import sys
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import Mock

import pytest
from geometry_msgs.msg import Transform
from rclpy.node import Node
from scipy.spatial.transform import Rotation

from shirube_core.geometry import SE3


class TransformError(Exception):
    """As tf2_ros.TransformException."""


class MemoryTf:
    """The TF of a test.

    Attributes:
        published: transforms that nodes published, by topic.
        latest: time of the latest transforms [s]; static ones are known at any time.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.published: dict[str, list[Any]] = {'/tf': [], '/tf_static': []}
        self.latest = float('inf')
        self._parents: dict[str, tuple[str, SE3, bool]] = {}
        tf2 = ModuleType('tf2_ros')
        tf2.Buffer = lambda: self  # type: ignore[attr-defined]
        tf2.TransformListener = Mock()  # type: ignore[attr-defined]
        tf2.TransformException = TransformError  # type: ignore[attr-defined]
        kind = lambda transforms: SimpleNamespace(transforms=transforms)  # noqa: E731
        messages = ModuleType('tf2_msgs.msg')
        messages.TFMessage = kind  # type: ignore[attr-defined]
        for module in (tf2, ModuleType('tf2_msgs'), messages):
            monkeypatch.setitem(sys.modules, module.__name__, module)
        create = Node.create_publisher

        def create_publisher(node: Node, what: Any, topic: str, *rest: Any, **options: Any) -> Any:
            if what is kind:
                return SimpleNamespace(publish=self.published[topic].append)
            return create(node, what, topic, *rest, **options)

        monkeypatch.setattr(Node, 'create_publisher', create_publisher)

    def join(self, parent: str, child: str, xyz: Any, rpy: Any = (0.0, 0.0, 0.0), *, is_static: bool = True) -> None:
        """Add ``T_parent_child``."""
        self._parents[child] = parent, SE3.from_rpy(xyz, rpy), is_static

    def lookup_transform(self, target: str, source: str, time: Any) -> Any:
        """As tf2_ros.Buffer: the chain from the source up to the root, and down to the target."""
        seconds = 1e-9 * time.nanoseconds
        T_target, T_source = (self._to_root(frame, seconds) for frame in (target, source))
        if T_target[0] != T_source[0]:
            raise TransformError('not connected')
        T = T_target[1].inverse() @ T_source[1]
        found = Transform()
        found.translation.x, found.translation.y, found.translation.z = T.position.tolist()
        quaternion = Rotation.from_matrix(T.rotation).as_quat().tolist()
        for name, value in zip('xyzw', quaternion, strict=True):
            setattr(found.rotation, name, value)
        return SimpleNamespace(transform=found)

    def _to_root(self, frame: str, seconds: float) -> tuple[str, SE3]:
        T = SE3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        while frame in self._parents:
            frame, T_parent_frame, is_static = self._parents[frame]
            if not is_static and seconds > self.latest:
                raise TransformError('in the future')
            T = T_parent_frame @ T
        return frame, T
