"""The doctor's checks: each is a function of a snapshot and yields findings with their remedies."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

import numpy as np

from shirube_cli.doctor.parameter_names import unknown_names
from shirube_cli.doctor.snapshot import SeenImages, SeenNode, Snapshot
from shirube_cli.lamp_bands import BANDS_MIN
from shirube_ros.camera.image import ENCODINGS
from vlc_beacon.core.light_code.rs_fsk import PREAMBLE_SYMBOL, TONE_LOWEST, TONE_SPACING
from vlc_beacon.core.light_code.ufsook import FRAME_RATE

_IMAGE_TYPES = {f'sensor_msgs/msg/{name}' for name in ('Image', 'CompressedImage')}
_FUTURE_MAX, _AGE_MAX = 1.0, 2.0  # tolerated stamps ahead of and behind the clock [s]
_RATE_TOLERANCE = 0.1
_READOUT_MIN = 0.2  # a rolling shutter that reads its rows in a smaller fraction of the frame period is unusual
_GLOBAL_EXPOSURE_MAX = 1e-3  # docs/vlc_beacon.md [s]
_ROLLING_EXPOSURE_MAX = 1.0 / (TONE_LOWEST + PREAMBLE_SYMBOL * TONE_SPACING)
"""Over one period of the highest tone its bands vanish [s]."""
_LAMPS_MIN = 5


class Severity(IntEnum):
    """How bad a finding is; an error makes the exit code 1."""

    ERROR = 0
    WARNING = 1
    NOTE = 2


@dataclass(frozen=True)
class Finding:
    """One line: what it is about, what is wrong, and what to do."""

    severity: Severity
    about: str
    text: str
    remedy: str


def check_snapshot(snapshot: Snapshot) -> list[Finding]:
    """Return all findings, the most severe first."""
    found = [finding for check in CHECKS for finding in check(snapshot)]
    return sorted(found, key=lambda finding: finding.severity)


def check_discovery(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield what keeps nodes from finding each other."""
    if snapshot.ros_fault:
        text = f'ROS does not start: {snapshot.ros_fault}'
        yield Finding(Severity.ERROR, 'ROS', text, 'install it as docs/install.md says, or correct RMW_IMPLEMENTATION')
    elif not snapshot.discovers_itself:
        text = 'two participants on this machine do not discover each other'
        remedy = 'allow UDP on loopback in the firewall; unset ROS_DISCOVERY_SERVER and FASTRTPS_DEFAULT_PROFILES_FILE'
        yield Finding(Severity.ERROR, 'DDS', text, remedy)
    elif not snapshot.nodes:
        domain, reach = (snapshot.environment.get(name, '') for name in _REACH)
        text = f'no node is seen in domain {domain or 0}, discovery range {reach or "SUBNET"}'
        remedy = f'start the nodes, with the same {_REACH[0]} and, for other machines, {_REACH[1]}=SUBNET'
        yield Finding(Severity.NOTE, 'DDS', text, remedy)


_REACH = ('ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE')


def check_names(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield names that several nodes have."""
    for node in snapshot.nodes:
        if node.count > 1:
            text = f'{node.count} nodes have this name; their parameters and transitions mix'
            yield Finding(Severity.ERROR, node.name, text, 'stop one, or rename it with -r __node:=other')


def check_inputs(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield inputs whose publishers are missing, or have another type or incompatible QoS."""
    counts = {each.topic: each.publishers for each in snapshot.inputs}
    for each in snapshot.inputs:
        about = f'{each.node} {each.topic}'
        for fault in each.faults:
            yield Finding(Severity.ERROR, about, fault, 'change the publisher, or remap the topic')
        base = each.topic.removesuffix('/compressed')
        is_camera = each.type in _IMAGE_TYPES or each.type == 'sensor_msgs/msg/CameraInfo'
        has_images = counts.get(base, 0) + counts.get(f'{base}/compressed', 0) > 0
        if is_camera and not has_images and not each.faults and each.topic == base:
            what = 'calibration' if each.type not in _IMAGE_TYPES else 'images'
            yield Finding(Severity.ERROR, about, f'nobody publishes the {what}', 'start the camera, or remap the topic')


def check_images(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield encodings that cannot be read, and calibrations for another image size."""
    for each in snapshot.images:
        if each.encoding and each.encoding not in ENCODINGS:
            text = f'the encoding {each.encoding} cannot be read'
            yield Finding(Severity.ERROR, each.topic, text, 'let the camera publish mono8, bgr8 or rgb8')
        if each.calibration is not None and each.calibration != each.size:
            images, calibration = (' x '.join(map(str, size)) for size in (each.size, each.calibration))
            text = f'images have {images} px, their calibration is for {calibration} px'
            yield Finding(Severity.ERROR, each.topic, text, 'calibrate at the size that is published')


def check_clocks(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield stamps that do not fit the clock, and nodes with different clocks."""
    simulated = {node.name: bool(node.parameters.get('use_sim_time')) for node in snapshot.nodes if node.parameters}
    if len(set(simulated.values())) > 1:
        real = ', '.join(name for name, is_simulated in simulated.items() if not is_simulated)
        text = f'some nodes use simulated time, these do not: {real}'
        yield Finding(Severity.ERROR, 'use_sim_time', text, 'set use_sim_time of all nodes alike')
    if any(simulated.values()) and not snapshot.has_clock:
        text = 'nodes use simulated time, but nobody publishes /clock: their time does not start'
        yield Finding(
            Severity.ERROR, 'use_sim_time', text, 'start the simulator, play the bag with --clock, or set it false'
        )
    for each in snapshot.images:
        age = float(np.median(each.ages)) if each.ages else 0.0
        if each.stamps and each.stamps[-1] == 0.0:
            yield Finding(Severity.ERROR, each.topic, 'stamps are 0', 'let the camera set header.stamp')
        elif any(later < earlier for earlier, later in pairwise(each.stamps)):
            text = 'stamps go back; a camera published twice, or a bag was started again'
            yield Finding(Severity.WARNING, each.topic, text, 'leave one publisher')
        elif not any(simulated.values()) and not -_FUTURE_MAX <= age <= _AGE_MAX:
            text = f'stamps are {abs(age):.1f} s {"old" if age > 0.0 else "in the future"}'
            remedy = 'synchronize the clocks (chrony); for a bag or simulator set use_sim_time'
            yield Finding(Severity.ERROR, each.topic, text, remedy)


def check_lamp_camera(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield shutter, line time and exposure of lamp receivers that do not fit their images."""
    for node in snapshot.nodes:
        topics = {each.topic for each in snapshot.inputs if each.node == node.name and each.type in _IMAGE_TYPES}
        images = [each for each in snapshot.images if each.topic in topics]
        if 'shutter' in node.parameters:
            yield from _check_exposure(node)
            for each in images:
                yield from _check_shutter(node, each)


def _check_exposure(node: SeenNode) -> Iterator[Finding]:
    exposure, is_rolling = _number(node, 'exposure_time'), node.parameters['shutter'] == 'rolling'
    longest = _ROLLING_EXPOSURE_MAX if is_rolling else _GLOBAL_EXPOSURE_MAX
    if exposure > longest:
        text = f'exposure_time is {1e6 * exposure:.0f} us; over {1e6 * longest:.0f} us the light code is blurred'
        remedy = 'set a shorter exposure in the camera and here; about 60 us with a rolling shutter'
        yield Finding(Severity.ERROR if is_rolling else Severity.WARNING, node.name, text, remedy)


def _check_shutter(node: SeenNode, images: SeenImages) -> Iterator[Finding]:
    is_rolling, about = node.parameters['shutter'] == 'rolling', f'{node.name} {images.topic}'
    changes = images.band_changes
    has_bands = len(changes) >= _LAMPS_MIN and float(np.median(changes)) >= BANDS_MIN
    if has_bands and not is_rolling:
        text = 'shutter is global, but the lamps have the bands of a rolling shutter'
        yield Finding(Severity.ERROR, about, text, 'set shutter to rolling, with row_time and exposure_time')
    if len(changes) >= _LAMPS_MIN and max(changes) < BANDS_MIN and is_rolling:
        text = 'shutter is rolling, but no lamp has bands: a global shutter, or too long an exposure'
        yield Finding(Severity.ERROR, about, text, 'set shutter to global, or the exposure of the camera to 60 us')
    period = float(np.median(np.diff(images.stamps))) if len(images.stamps) >= _LAMPS_MIN else 0.0
    if period <= 0.0:
        return
    if not is_rolling and not has_bands and abs(period * FRAME_RATE - 1.0) > _RATE_TOLERANCE:
        text = f'{1.0 / max(period, 1e-6):.0f} images/s; a global shutter reads lamps at {FRAME_RATE:.0f}'
        yield Finding(Severity.ERROR, about, text, f'set the camera to {FRAME_RATE:.0f} images/s')
    readout = _number(node, 'row_time') * images.size[1]
    if is_rolling and not _READOUT_MIN * period <= readout <= (1.0 + _RATE_TOLERANCE) * period:
        text = f'row_time x {images.size[1]} rows is {1e3 * readout:.1f} ms, the frame period {1e3 * period:.1f} ms'
        severity = Severity.ERROR if readout > period else Severity.WARNING
        yield Finding(severity, about, text, "set row_time to the line time of the camera's mode")


def _number(node: SeenNode, name: str) -> float:
    value = node.parameters.get(name, 0.0)
    return float(value) if isinstance(value, (int, float)) else 0.0


def check_reports(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield what our nodes report of themselves."""
    for name, is_error, message in snapshot.statuses:
        severity = Severity.ERROR if is_error else Severity.WARNING
        yield Finding(severity, name, message, "as the line says; see the node's page in docs/")


def check_files(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield unknown and misspelled parameters in parameter files."""
    for path, content in snapshot.files.items():
        for name, close in unknown_names(content):
            remedy = f'write {close}' if close else 'remove it; docs/parameters.md lists the names'
            yield Finding(Severity.ERROR, path, f'there is no parameter {name}', remedy)


def check_ports(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield serial ports that are missing or not permitted."""
    for port in snapshot.ports:
        if not port.exists:
            yield Finding(Severity.ERROR, port.path, 'is not there', 'plug it in; ls /dev/serial/by-id names the ports')
        elif not port.is_permitted:
            text = 'may not be read and written by this user'
            yield Finding(Severity.ERROR, port.path, text, 'sudo usermod -aG dialout $USER, then log in again')


CHECKS: tuple[Callable[[Snapshot], Iterator[Finding]], ...] = (
    *(check_discovery, check_names, check_inputs, check_images, check_clocks),
    *(check_lamp_camera, check_reports, check_files, check_ports),
)
