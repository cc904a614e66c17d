"""What the commands share: errors of one line each, and options that are defined by a settings class."""

import argparse
import sys
from collections.abc import Callable, Collection
from dataclasses import fields
from pathlib import Path
from typing import TypeVar

from shirube_core.settings import check_settings, describe_settings, reject_former_option

Settings = TypeVar('Settings')


def run_command(
    name: str, work: Callable[[], int | None], errors: tuple[type[Exception], ...], out: Path | None = None
) -> int:
    """Do the work of a command; return its exit code, or 1 after one line on stderr about what is wrong.

    Args:
        name: name of the command, with which the line begins.
        work: returns the exit code, or None for 0.
        errors: errors of files and options, whose message is the line.
        out: output that is named for errors of the system without a file.
    """
    try:
        return work() or 0
    except errors as fault:
        line = str(fault)
    except OSError as fault:
        line = f'{fault.filename or out}: {fault.strerror}; choose a writable place'
    print(f'{name}: {line}', file=sys.stderr)  # noqa: T201 for the user of a command
    return 1


def add_settings(parser: argparse.ArgumentParser, cls: type, names: Collection[str] = ()) -> None:
    """Add an option for each setting of a class, or for the named ones only."""
    for each in describe_settings(cls):
        if names and each.name not in names:
            continue
        unit = f' [{each.unit}]' if each.unit else ''
        choices = f': {each.limits}' if each.choices else ''
        about = f'{each.description}{choices}{unit}'.replace('%', '%%')
        option, help_text = f'--{each.name.replace("_", "-")}', f'{about} (default: %(default)s)'
        if each.type is bool:
            parser.add_argument(option, action=argparse.BooleanOptionalAction, default=each.default, help=help_text)
        else:
            parser.add_argument(option, type=each.type, default=each.default, help=help_text)
        if each.former_name:
            reject_former_option(parser, each.former_name, each.name)


def settings_from(options: argparse.Namespace, cls: type[Settings]) -> Settings:
    """Return the settings from the parsed options of `add_settings`; raise a SettingsError if one is out of range."""
    settings = cls(**{field.name: getattr(options, field.name) for field in fields(cls)})  # type: ignore[arg-type]
    check_settings(settings)
    return settings
