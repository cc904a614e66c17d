"""Command line options that have another name now."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any


class _RenamedOption(argparse.Action):
    """Reject an option under its former name with the new one in the message."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,  # noqa: ARG002 argparse wants it
        values: str | Sequence[Any] | None,  # noqa: ARG002
        option_string: str | None = None,
    ) -> None:
        parser.error(f'{option_string} is now called {option_name(self.dest)}')


def reject_former_option(parser: argparse.ArgumentParser, former_name: str, name: str) -> None:
    """Let a parser reject the former name of an option; the help does not show it.

    Args:
        parser: parser that has the option under its new name.
        former_name: former name of the setting behind it, with underscores.
        name: its new name, with underscores.
    """
    parser.add_argument(
        option_name(former_name),
        dest=name,
        action=_RenamedOption,
        default=argparse.SUPPRESS,
        help=argparse.SUPPRESS,
    )


def option_name(setting_name: str) -> str:
    """Return the option of a setting: ``--submap-length`` of ``submap_length``."""
    return f'--{setting_name.replace("_", "-")}'
