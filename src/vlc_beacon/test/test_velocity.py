import pytest

from vlc_beacon.core.drive.velocity import Velocity


def test_steps_lead_to_what_is_wanted_and_end_there() -> None:
    velocity, target = Velocity(0.5, -1.0), Velocity(-0.2, 0.5)
    for _ in range(7):
        before, velocity = velocity, velocity.step_toward(target, 0.1, 0.3)
        assert abs(velocity.forward - before.forward) <= 0.1 + 1e-12
        assert abs(velocity.turn_rate - before.turn_rate) <= 0.3 + 1e-12
    assert velocity.forward == pytest.approx(target.forward)
    assert velocity.step_toward(target, 0.1, 0.3) == target


def test_only_zero_velocity_is_zero() -> None:
    assert Velocity().is_zero
    assert not Velocity(0.0, 0.1).is_zero
    assert not Velocity(-0.1, 0.0).is_zero
