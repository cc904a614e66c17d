"""Command line options generated from a settings class, with defaults and units."""

from __future__ import annotations

import argparse
from dataclasses import fields
from typing import TypeVar

from shirube_core.settings import check_settings, describe_settings, reject_former_option

Settings = TypeVar('Settings')


def add_settings(parser: argparse.ArgumentParser, cls: type) -> None:
    """Add an option for each setting of a class."""
    for each in describe_settings(cls):
        unit = f' [{each.unit}]' if each.unit else ''
        parser.add_argument(
            f'--{each.name.replace("_", "-")}',
            type=each.type,
            default=each.default,
            help=f'{each.description}{unit} (default: %(default)s)',
        )
        if each.former_name:
            reject_former_option(parser, each.former_name, each.name)


def settings_from(options: argparse.Namespace, cls: type[Settings]) -> Settings:
    """Return the settings from the parsed options.

    Raises:
        SettingsError: a setting is out of range.
    """
    settings = cls(**{field.name: getattr(options, field.name) for field in fields(cls)})  # type: ignore[arg-type]
    check_settings(settings)
    return settings
