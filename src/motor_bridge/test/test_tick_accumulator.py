import numpy as np
import pytest

from motor_bridge.core.base_drive import TickAccumulator, clamp_ticks

FRAME = 0.033


@pytest.mark.parametrize('wanted', [0.04, 0.5, 3.7, -0.3, -12.01])
@pytest.mark.parametrize('period', [FRAME, 0.1])
def test_slow_motion_is_not_lost(wanted, period):
    rounding = TickAccumulator(FRAME, period)
    given = [rounding.round(wanted, period) for _ in range(2000)]
    way, wanted_way = sum(given) * period / FRAME, wanted * 2000 * period / FRAME
    assert abs(way - wanted_way) <= 1.5 * period / FRAME + 1e-6
    assert max(abs(g - wanted) for g in given) < 1.0


def test_irregular_calls_make_the_same_way():
    rng = np.random.default_rng(5)
    rounding, way, wanted_way, wanted, given = TickAccumulator(FRAME, FRAME), 0.0, 0.0, 0.0, 0
    for step in range(5000):
        elapsed = float(rng.uniform(0.001, 0.05))
        way += given * elapsed / FRAME
        wanted_way += wanted * elapsed / FRAME
        wanted = 5.3 + 4.0 * np.sin(0.01 * step)
        given = rounding.round(wanted, elapsed)
        assert abs(way - wanted_way) < 3.0


def test_a_stopped_wheel_does_not_turn():
    rounding = TickAccumulator(FRAME, FRAME)
    for _ in range(7):
        rounding.round(0.4, FRAME)
    assert [rounding.round(0.0, FRAME) for _ in range(5)] == [0] * 5


def test_the_error_is_not_carried_over_a_reversal():
    rounding = TickAccumulator(FRAME, FRAME)
    rounding.round(0.4, FRAME)
    assert rounding.round(-1.0, 100.0) == -1


@pytest.mark.parametrize('pair', [(40000.0, 20000.0), (-1e6, 3e5), (1e9, -1e9)])
def test_clamping_keeps_the_curvature(pair):
    left, right = clamp_ticks(*pair)
    assert max(abs(left), abs(right)) == pytest.approx(32767.0)
    assert left * pair[1] == pytest.approx(right * pair[0])


def test_what_fits_is_left_alone():
    assert clamp_ticks(32767.0, -12.5) == (32767.0, -12.5)
