"""The firmware's command parser, byte by byte, to emulate lost and corrupted bytes."""

from __future__ import annotations

from dataclasses import dataclass

ARGUMENT_MAX = 16
"""Longest argument [bytes]; longer ones are undefined behaviour on the microcontroller."""


@dataclass(frozen=True)
class ReceivedCommand:
    """A command as the firmware parses it.

    Attributes:
        letter: letter of the command, empty for an empty line.
        first: first argument as received.
        second: second argument as received.
    """

    letter: str
    first: str
    second: str


class CommandReader:
    """Collects bytes until a carriage return ends a command.

    A space starts an argument; spaces after the second argument are ignored. Before an argument, the last byte is the
    letter. So ``m 1`` without its carriage return, followed by ``m 10 10``, is parsed as ``m 1 1010``.
    """

    _letter: str
    _arguments: list[str]

    def __init__(self) -> None:
        """Start with an empty line."""
        self._clear()

    def take(self, byte: int) -> ReceivedCommand | None:
        """Add a byte; return the command if it is complete, else None."""
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
