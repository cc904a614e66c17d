"""Loads the beacons, key and counters named by the settings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from vlc_beacon.core.authorization.authorization_settings import AuthorizationSettings
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.beacons_file import load_beacons
from vlc_beacon.files.counter_file import CounterFile
from vlc_beacon.files.key_file import read_key
from vlc_beacon.node_settings import NodeSettings


def beacons_from_settings(settings: NodeSettings) -> list[Beacon]:
    """Load the beacons.

    Raises:
        VlcBeaconError: no file is set, or it is invalid.
    """
    if not settings.beacons_file:
        raise VlcBeaconError(
            'beacons_file is not set; give the YAML file of your lamps, see config/beacons.yaml'
        )
    return load_beacons(_path(settings.beacons_file, 'beacons_file'))


def authorizer_from_settings(
    settings: NodeSettings, authorization: AuthorizationSettings, beacons: Iterable[Beacon]
) -> CommandAuthorizer:
    """Create the authorizer of commands; without a key it rejects all.

    Raises:
        VlcBeaconError: the key is invalid, or a counter file is missing.
    """
    if settings.key_file and not settings.counter_file:
        raise VlcBeaconError(
            'counter_file is not set; commands with a key need a file that stores their counters'
        )
    key = read_key(_path(settings.key_file, 'key_file')) if settings.key_file else None
    store = CounterFile(_path(settings.counter_file, 'counter_file'))
    positions = {beacon.id: (beacon.xyz[0], beacon.xyz[1]) for beacon in beacons}
    return CommandAuthorizer(key, store, positions, authorization)


def _path(text: str, parameter: str) -> Path:
    try:
        return Path(text).expanduser()
    except RuntimeError as fault:
        raise VlcBeaconError(f'{parameter} is {text}: no such user; give an absolute path') from fault
