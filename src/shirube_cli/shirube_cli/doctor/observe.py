"""The ROS part of the doctor: looks at a running system for some seconds."""

import os
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import monotonic, time
from typing import Any

from shirube_cli.doctor.snapshot import SeenImages, SeenInput, SeenNode, SeenPort, Snapshot
from shirube_cli.settings_of_nodes import SETTINGS_OF_NODES

_NAME = 'shirube_doctor'
_PARAMETERS = ('use_sim_time', 'shutter', 'row_time', 'exposure_time', 'port')
_KINDS = {'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage', 'sensor_msgs/msg/CameraInfo'}
_BANDED_IMAGES = 6  # images of a topic in which lamps are searched


def observe(seconds: float, files: Mapping[str, object], ports: Sequence[str]) -> Snapshot:
    """Return a snapshot of the system around this process and of parameter files and ports."""
    environment = {name: value for name, value in os.environ.items() if name.startswith(('ROS_', 'RMW_'))}
    try:
        import rclpy  # noqa: PLC0415 the doctor is for systems where this fails
        from rclpy.context import Context  # noqa: PLC0415

        own, other = Context(), Context()
        rclpy.init(context=own)
        rclpy.init(context=other)
    except Exception as fault:  # noqa: BLE001 whatever fails is the finding
        line = ' '.join(str(fault).split())
        return Snapshot(ros_fault=line, environment=environment, files=files, ports=see_ports(ports))
    try:
        return _Observer(own, other).look(seconds, environment, files, ports)
    finally:
        rclpy.shutdown(context=own)
        rclpy.shutdown(context=other)


def see_ports(paths: Sequence[str]) -> tuple[SeenPort, ...]:
    """Return serial ports: the given ones and those of this machine."""
    found = {str(path) for name in ('ttyUSB*', 'ttyACM*') for path in Path('/dev').glob(name)}
    return tuple(
        SeenPort(path, Path(path).exists(), os.access(path, os.R_OK | os.W_OK)) for path in sorted({*paths, *found})
    )


class _Observer:
    def __init__(self, own: Any, other: Any) -> None:
        from diagnostic_msgs.msg import DiagnosticArray  # noqa: PLC0415 only where ROS starts
        from rclpy.executors import SingleThreadedExecutor  # noqa: PLC0415
        from rclpy.node import Node  # noqa: PLC0415

        self._node = Node(_NAME, context=own, enable_rosout=False)
        self._other = Node(f'{_NAME}_peer', context=other, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=own)
        self._executor.add_node(self._node)
        self._statuses: dict[str, tuple[bool, str]] = {}
        self._messages: dict[str, list[tuple[float, Any]]] = defaultdict(list)
        self._node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def look(
        self, seconds: float, environment: Mapping[str, str], files: Mapping[str, object], ports: Sequence[str]
    ) -> Snapshot:
        """Discover for the first half of the time, and listen for the second."""
        self._spin(0.5 * seconds)
        listed = Counter(
            f'{namespace.rstrip("/")}/{name}'
            for name, namespace in self._node.get_node_names_and_namespaces()
            if not name.startswith((_NAME, '_'))
        )
        ours = [name for name in listed if name.rpartition('/')[2] in SETTINGS_OF_NODES]
        inputs = [each for name in ours for each in self._inputs_of(name)]
        self._listen({(each.topic, each.type) for each in inputs if each.type in _KINDS and each.publishers})
        requests = {name: self._request(name) for name in listed}
        self._spin(0.5 * seconds)
        nodes = [SeenNode(name, count, _answer(requests[name])) for name, count in listed.items()]
        given = [str(n.parameters['port']) for n in nodes if n.parameters.get('port') and n.name in ours]
        peers = self._node.get_node_names()
        return Snapshot(
            discovers_itself=f'{_NAME}_peer' in peers,
            environment=environment,
            nodes=tuple(nodes),
            inputs=tuple(inputs),
            images=tuple(self._images()),
            has_clock=self._node.count_publishers('/clock') > 0,
            statuses=tuple((name, *status) for name, status in self._statuses.items()),
            files=files,
            ports=see_ports([*ports, *given]),
        )

    def _spin(self, seconds: float) -> None:
        end = monotonic() + seconds
        while (left := end - monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def _inputs_of(self, full_name: str) -> list[SeenInput]:
        from rclpy.qos import QoSCompatibility, qos_check_compatible  # noqa: PLC0415

        namespace, _, name = full_name.rpartition('/')
        inputs = []
        for topic, kinds in self._node.get_subscriber_names_and_types_by_node(name, namespace or '/'):
            wanted = [
                each
                for each in self._node.get_subscriptions_info_by_topic(topic)
                if (each.node_name, each.node_namespace) == (name, namespace or '/')
            ]
            publishers, faults = 0, []
            for publisher in self._node.get_publishers_info_by_topic(topic):
                if publisher.topic_type not in kinds:
                    faults.append(f'is published as {publisher.topic_type}, not as {kinds[0]}')
                    continue
                publishers += 1
                for own in wanted[:1]:
                    answer, reason = qos_check_compatible(publisher.qos_profile, own.qos_profile)
                    if answer == QoSCompatibility.ERROR:
                        why = ' '.join(reason.replace('ERROR: ', '').split())
                        faults.append(f'{publisher.node_name} publishes it with incompatible QoS: {why}')
            inputs.append(SeenInput(full_name, topic, kinds[0], publishers, tuple(faults)))
        return inputs

    def _listen(self, topics: set[tuple[str, str]]) -> None:
        from rclpy.qos import qos_profile_sensor_data  # noqa: PLC0415
        from sensor_msgs import msg  # noqa: PLC0415

        for topic, kind in topics:
            kept = self._messages[topic]
            self._node.create_subscription(
                getattr(msg, kind.rpartition('/')[2]),
                topic,
                lambda message, kept=kept: kept.append((time(), message)),
                qos_profile_sensor_data,
            )

    def _request(self, full_name: str) -> Any:
        from rcl_interfaces.srv import GetParameters  # noqa: PLC0415

        client = self._node.create_client(GetParameters, f'{full_name}/get_parameters')
        # A node answers nothing if it lacks one of several names.
        return {
            name: client.call_async(GetParameters.Request(names=[name]))
            for name in _PARAMETERS
            if client.wait_for_service(timeout_sec=0.2)
        }

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            node, _, what = status.name.partition(': ')
            if what == 'status' and node.rpartition('/')[2] in SETTINGS_OF_NODES:
                level = status.level[0]
                self._statuses.pop(f'/{node}', None)
                if level:
                    self._statuses[f'/{node}'] = level > 1, status.message

    def _images(self) -> list[SeenImages]:
        return [
            see_images(topic, kept, self._calibration(topic))
            for topic, kept in self._messages.items()
            if kept and not hasattr(kept[0][1], 'distortion_model')
        ]

    def _calibration(self, topic: str) -> tuple[int, int] | None:
        base = topic.removesuffix('/compressed').rpartition('/')[0]
        kept = self._messages.get(f'{base}/camera_info', [])
        return (kept[-1][1].width, kept[-1][1].height) if kept else None


def _answer(requests: Mapping[str, Any]) -> dict[str, object]:
    from rclpy.parameter import parameter_value_to_python  # noqa: PLC0415

    answers = {name: request.result() for name, request in requests.items() if request.done()}
    values = {name: parameter_value_to_python(a.values[0]) for name, a in answers.items() if a and a.values}
    return {name: value for name, value in values.items() if value is not None}


def see_images(topic: str, kept: Sequence[tuple[float, Any]], calibration: tuple[int, int] | None) -> SeenImages:
    """Return what received images show: pairs of the time of reception [s] and the message, oldest first."""
    import cv2  # noqa: PLC0415 takes a while

    from shirube_cli.lamp_bands import count_band_changes  # noqa: PLC0415
    from shirube_ros.camera.image import array_from_compressed_image, array_from_image  # noqa: PLC0415
    from shirube_ros.errors import MessageError  # noqa: PLC0415

    stamps = [message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec for _, message in kept]
    ages = [received - stamp for (received, _), stamp in zip(kept, stamps, strict=True)]
    size, changes, encoding = (0, 0), list[int](), ''
    for _, message in kept[-_BANDED_IMAGES:]:
        encoding = getattr(message, 'encoding', '')
        read = array_from_image if encoding else array_from_compressed_image
        try:
            pixels = read(message, topic)
        except MessageError:
            continue
        size = (pixels.shape[1], pixels.shape[0])
        grey = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
        changes += count_band_changes(grey)
    return SeenImages(topic, encoding, size, calibration, tuple(stamps), tuple(ages), tuple(changes))
