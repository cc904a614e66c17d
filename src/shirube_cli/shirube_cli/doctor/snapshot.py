"""What the doctor has seen of a system: numbers and texts only, so that each check is a function of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class SeenNode:
    """A node with its full name, how many have that name, and its parameters, none if it did not answer."""

    name: str
    count: int = 1
    parameters: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class SeenInput:
    """A subscription of one of our nodes.

    Attributes:
        node: full name of the node.
        topic: name of the topic.
        type: type of the messages, such as ``sensor_msgs/msg/Image``.
        publishers: number of publishers of this type.
        faults: why a publisher's messages do not arrive, one line each.
    """

    node: str
    topic: str
    type: str
    publishers: int = 0
    faults: tuple[str, ...] = ()


@dataclass(frozen=True)
class SeenImages:
    """The images of a topic.

    Attributes:
        topic: name of the topic.
        encoding: encoding of the latest image, empty if it is compressed.
        size: width and height of the latest image [px].
        calibration: width and height in its CameraInfo [px], None without one.
        stamps: stamps in the order of reception [s].
        ages: times of reception by the system's clock minus the stamps [s].
        band_changes: changes between bright and dark along the rows of each lamp, in some of the images.
    """

    topic: str
    encoding: str
    size: tuple[int, int]
    calibration: tuple[int, int] | None
    stamps: tuple[float, ...]
    ages: tuple[float, ...]
    band_changes: tuple[int, ...] = ()


@dataclass(frozen=True)
class SeenPort:
    """A serial port: its path, and whether it exists and may be read and written."""

    path: str
    exists: bool
    is_permitted: bool


@dataclass(frozen=True)
class Snapshot:
    """All that the doctor has seen.

    Attributes:
        ros_fault: why there is no ROS, empty if there is.
        discovers_itself: whether two participants of this process discovered each other.
        environment: environment variables of ROS.
        nodes: nodes, without the doctor's.
        inputs: subscriptions of our nodes.
        images: received images by topic.
        has_clock: whether somebody publishes ``/clock``.
        statuses: name, whether it is an error, and message of each diagnostic status of our nodes that is not OK.
        files: contents of parameter files by path.
        ports: serial ports.
    """

    ros_fault: str = ''
    discovers_itself: bool = True
    environment: Mapping[str, str] = field(default_factory=dict)
    nodes: tuple[SeenNode, ...] = ()
    inputs: tuple[SeenInput, ...] = ()
    images: tuple[SeenImages, ...] = ()
    has_clock: bool = False
    statuses: tuple[tuple[str, bool, str], ...] = ()
    files: Mapping[str, object] = field(default_factory=dict)
    ports: tuple[SeenPort, ...] = ()
