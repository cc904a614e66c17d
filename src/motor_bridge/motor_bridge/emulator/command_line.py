"""The firmware's reader of commands, byte for byte: what a lost or a strange byte makes of a command."""

from __future__ import annotations

from dataclasses import dataclass

ARGUMENT_MAX = 16
"""Bytes of an argument that are kept; what more do on the microcontroller is undefined."""


@dataclass(frozen=True)
class ReceivedCommand:
    """A command as the firmware understood it.

    Attributes:
        letter: empty if nothing stood before the carriage return.
        first: its first argument as it came.
        second: its second argument as it came.
    """

    letter: str
    first: str
    second: str


class CommandReader:
    """Takes bytes until a carriage return ends a command.

    A space begins an argument, the third one and those after it are passed over; outside of an argument the last byte
    is the letter. So ``m 1`` without its end, followed by ``m 10 10``, is understood as ``m 1 1010``.
    """

    _letter: str
    _arguments: list[str]

    def __init__(self) -> None:
        """Wait for a command."""
        self._clear()

    def take(self, byte: int) -> ReceivedCommand | None:
        """Take a byte; return the command that it ends, None if it ends none."""
        character = chr(byte)
        if character == '\r':
            first, second, *_ = [*self._arguments, '', '']
            command = ReceivedCommand(self._letter, first, second)
            self._clear()
            return command
        if character == ' ':
            if len(self._arguments) < 2:
                self._arguments.append('')
        elif not self._arguments:
            self._letter = character
        elif len(self._arguments[-1]) < ARGUMENT_MAX:
            self._arguments[-1] += character
        return None

    def _clear(self) -> None:
        self._letter = ''
        self._arguments = []
