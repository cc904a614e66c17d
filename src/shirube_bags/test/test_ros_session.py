"""Signals set the stop event, only inside the context."""

import os
import signal

import pytest

from shirube_bags.ros_session import stop_on_signals


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_sets_the_event_and_the_former_handler_comes_back(number):
    former = signal.getsignal(number)
    with stop_on_signals() as stop:
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        assert stop.wait(5.0)
    assert signal.getsignal(number) is former
