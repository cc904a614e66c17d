"""The paper's room and its ceiling."""

from __future__ import annotations

import pytest

from scene_simulator.ceiling_room import PAPER_LAMPS, CeilingRoom, paper_room
from scene_simulator.distractor_lights import distractors
from scene_simulator.errors import SceneError
from shirube_core.waveform import steady_light

WAVEFORMS = [steady_light() for _ in range(4)]


def test_the_paper_has_four_panels_each_with_its_own_waveform() -> None:
    room = paper_room(WAVEFORMS)
    assert [lamp.xyz for lamp in room.lamps] == list(PAPER_LAMPS)
    assert [lamp.waveform for lamp in room.lamps] == WAVEFORMS
    assert room.surface is None


def test_more_lights_come_after_the_lamps() -> None:
    room = paper_room(WAVEFORMS).with_ambient_light(10.0).with_lights(distractors())
    assert room.lamps[:4] == paper_room(WAVEFORMS).lamps
    assert len(room.lamps) == 8
    assert room.surface is not None


def test_the_ceiling_hangs_just_above_the_lamps() -> None:
    surface = paper_room(WAVEFORMS).with_ambient_light(10.0).surface
    assert surface is not None
    assert 0.0 < surface.height - 2.5 < 0.05
    assert surface.ambient == 10.0


def test_wrong_rooms_are_refused() -> None:
    with pytest.raises(SceneError, match='4 waveforms'):
        paper_room(WAVEFORMS[:3])
    with pytest.raises(SceneError, match='lamp'):
        CeilingRoom().with_ambient_light(1.0)
