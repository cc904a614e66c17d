"""Parameters of the node, and the files that they name."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from shirube_core.settings import setting
from shirube_ros.camera.settings import CameraSettings
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.command_executor import DriveSettings
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import CounterFile, read_key
from vlc_beacon.files.beacons_file import load_beacons


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """Camera mount, frames, files and drive mode; drive parameters in a group."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.2),
        'position of the optical frame in base_frame, whose plane z = 0 is the floor',
        'm',
        (-10.0, 10.0),
    )
    camera_rpy: tuple[float, float, float] = setting(
        (0.0, 0.0, math.pi / 2.0),
        'fixed-axis roll, pitch, yaw of the optical frame in base_frame; default: upward, top of the image ahead',
        'rad',
        (-math.tau, math.tau),
    )
    beacons_file: str = setting('', 'beacons file: YAML of lamp IDs and positions; required')
    key_file: str = setting('', 'key file of the commands; without a key all commands are rejected')
    counter_file: str = setting('', 'file that stores the counters of commands over restarts')
    drive: bool = setting(False, 'whether the node executes commands and publishes ~/cmd_vel')
    driving: DriveSettings = field(default_factory=DriveSettings)


def beacons_from_settings(settings: NodeSettings) -> list[Beacon]:
    """Load the beacons; raises `VlcBeaconError` if no file is set, or it is invalid."""
    if not settings.beacons_file:
        raise VlcBeaconError('beacons_file is not set; give the YAML file of your lamps, see config/beacons.yaml')
    return load_beacons(_path(settings.beacons_file, 'beacons_file'))


def authorizer_from_settings(
    settings: NodeSettings, authorization: AuthorizationSettings, beacons: Iterable[Beacon]
) -> CommandAuthorizer:
    """Create the authorizer of commands, which rejects all without a key; raises `VlcBeaconError`."""
    if settings.key_file and not settings.counter_file:
        raise VlcBeaconError('counter_file is not set; commands with a key need a file that stores their counters')
    key = read_key(_path(settings.key_file, 'key_file')) if settings.key_file else None
    store = CounterFile(_path(settings.counter_file, 'counter_file'))
    positions = {beacon.id: (beacon.xyz[0], beacon.xyz[1]) for beacon in beacons}
    return CommandAuthorizer(key, store, positions, authorization)


def _path(text: str, parameter: str) -> Path:
    try:
        return Path(text).expanduser()
    except RuntimeError as fault:
        raise VlcBeaconError(f'{parameter} is {text}: no such user; give an absolute path') from fault
