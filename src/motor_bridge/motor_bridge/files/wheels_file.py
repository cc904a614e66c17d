"""Reads and updates the wheel parameters in a parameter file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path

from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from shirube_core.files import YamlFileError, read_yaml, write_text
from shirube_core.settings import SettingsError, settings_from_values

_NODE = 'motor_bridge'


def read_drive_settings(path: Path) -> DriveSettings:
    """Read the drive settings from a parameter file.

    Raises:
        MotorBridgeError: it is missing or corrupted, or has invalid values.
    """
    try:
        node = read_yaml(path).get(_NODE)
        parameters = node.get('ros__parameters') if isinstance(node, dict) else None
        if not isinstance(parameters, dict):
            raise MotorBridgeError(
                f'{path}: has no {_NODE}: ros__parameters:; start from config/motor_bridge.yaml'
            )
        names = {field.name for field in fields(DriveSettings)}
        return settings_from_values(DriveSettings, {k: v for k, v in parameters.items() if k in names})
    except YamlFileError as fault:
        raise MotorBridgeError(f'{fault}; start from config/motor_bridge.yaml') from fault
    except SettingsError as fault:
        raise MotorBridgeError(f'{path}: {fault}') from fault


def write_values(source: Path, path: Path, values: Mapping[str, float]) -> None:
    """Write a parameter file with some changed values; comments and everything else stay.

    Args:
        source: input file.
        path: output file, written atomically.
        values: new values by name of the parameter.

    Raises:
        OSError: the file cannot be written.
        MotorBridgeError: the file does not have one parameter per line.
    """
    text = source.read_text(encoding='utf-8')
    section = re.search(rf'(?m)^{_NODE}:.*(?:\n[ \t#].*|\n)*', text)
    if section is None:
        raise MotorBridgeError(f'{source}: has no {_NODE}:; start from config/motor_bridge.yaml')
    own = section[0]
    for name, value in values.items():
        own, count = re.subn(rf'(?m)^(\s+{name}:)[^#\n]*?(\s*#.*)?$', rf'\g<1> {value:.6g}\g<2>', own)
        if count == 0:
            own, count = re.subn(
                r'(?m)^(\s+)ros__parameters:[ \t]*$', rf'\g<0>\n\g<1>  {name}: {value:.6g}', own, count=1
            )
        if count == 0:
            raise MotorBridgeError(
                f'{source}: {name} needs its own line; write one parameter per line, as config/motor_bridge.yaml does'
            )
    write_text(path, text[: section.start()] + own + text[section.end() :])
