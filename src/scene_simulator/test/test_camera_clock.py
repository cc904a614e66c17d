"""Frame times, jitter and dropped frames."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.camera_clock import CameraClock
from scene_simulator.errors import SceneError


def test_an_ideal_clock_has_even_ticks_and_true_stamps() -> None:
    starts, stamps = CameraClock(60.0).frames(2.0, np.random.default_rng(0))
    np.testing.assert_allclose(starts, np.arange(120) / 60.0, atol=1e-12)
    np.testing.assert_array_equal(stamps, starts)


def test_jitter_and_losses_are_as_large_as_asked_for() -> None:
    clock = CameraClock(60.0, stamp_jitter=50e-6, drop_fraction=0.1)
    starts, stamps = clock.frames(300.0, np.random.default_rng(1))
    assert len(starts) == pytest.approx(0.9 * 18_000, rel=0.02)
    assert (stamps - starts).std() == pytest.approx(50e-6, rel=0.05)
    np.testing.assert_allclose(starts * 60.0, np.rint(starts * 60.0), atol=1e-9)


def test_the_same_source_gives_the_same_frames() -> None:
    clock = CameraClock(30.0, 1e-4, 0.2)
    one, same = (clock.frames(3.0, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one[1], same[1])


@pytest.mark.parametrize(('rate', 'jitter', 'drops'), [(0.0, 0.0, 0.0), (60.0, -1.0, 0.0), (60.0, 0.0, 1.0)])
def test_clocks_that_cannot_be_are_refused(rate: float, jitter: float, drops: float) -> None:
    with pytest.raises(SceneError, match='camera'):
        CameraClock(rate, jitter, drops)


def test_a_recording_without_length_is_refused() -> None:
    with pytest.raises(SceneError, match='seconds'):
        CameraClock().frames(0.0, np.random.default_rng(0))
