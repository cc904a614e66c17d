"""A bag on a time line."""

from pathlib import Path

import pytest

from shirube_view.board import Seen
from shirube_view.recording import Recording

MISSION = Path(__file__).parents[3] / 'bags' / 'mission'


@pytest.fixture
def recording():
    recording = Recording(MISSION)
    yield recording
    recording.close()


def shown(recording):
    """Return the names of what is shown, and the whole as text."""
    recording.board.update()
    return recording.board.news(Seen())


def test_a_jump_shows_what_playing_to_that_time_shows(recording):
    recording.speed = 10.0
    while recording.time < 20.0:
        recording.advance(0.05)
    played, time = shown(recording), recording.time
    recording.seek(70.0)
    assert shown(recording) != played
    recording.seek(time)
    jumped = shown(recording)
    # What was silent for the last seconds is not shown after a jump.
    for name in ('map', 'plan', 'goal', 'fused', 'odom', 'floor_localizer'):
        assert member(jumped, name) == member(played, name) != ''


def member(text, name):
    start = text.index(f'"{name}":')
    return text[start : text.find(',"', text.find('}}', start))][:300]


def test_time_stays_within_the_bag_and_a_pause_holds_it(recording):
    recording.seek(1e6)
    assert recording.time == recording.length
    recording.advance(1.0)
    assert recording.time == recording.length
    recording.seek(-5.0)
    recording.speed = 0.0
    recording.advance(1.0)
    assert recording.time == 0.0
