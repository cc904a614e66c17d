"""The space bar pauses; the terminal is as before at the end."""

import os
import pty
import termios

import pytest

from shirube_bags.commands import play as module
from shirube_bags.commands.play import is_in_foreground, pause_key


@pytest.fixture
def terminal(monkeypatch):
    """Yields the end on which keys are typed, and the end that the program reads."""
    keyboard, screen = pty.openpty()
    with os.fdopen(screen, closefd=False) as stdin:
        monkeypatch.setattr('sys.stdin', stdin)
        yield keyboard, screen
    os.close(keyboard)
    os.close(screen)


def test_space_pauses_and_continues_and_other_keys_do_nothing(terminal, monkeypatch):
    keyboard, screen = terminal
    monkeypatch.setattr(module, 'is_in_foreground', lambda: True)
    before, changes = termios.tcgetattr(screen), []
    with pause_key(changes.append) as is_paused:
        seen = [is_paused()]
        for keys in (b' ', b'x', b' ', b'  ', b' a  '):
            os.write(keyboard, keys)
            seen.append(is_paused())
    assert seen == [False, True, True, False, False, True]
    assert changes == [True, False, True]
    assert termios.tcgetattr(screen) == before


def test_without_a_terminal_in_the_foreground_nothing_is_read(terminal):
    keyboard, screen = terminal
    assert not is_in_foreground()  # the terminal is that of no process
    before = termios.tcgetattr(screen)
    with pause_key(lambda _: None) as is_paused:
        assert termios.tcgetattr(screen) == before
        os.write(keyboard, b' ')
        assert not is_paused()
