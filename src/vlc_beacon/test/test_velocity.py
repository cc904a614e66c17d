import pytest

from vlc_beacon.core.drive.velocity import Velocity


def test_steps_lead_to_what_is_wanted_and_end_there() -> None:
    velocity, wanted = Velocity(0.5, -1.0), Velocity(-0.2, 0.5)
    for _ in range(7):
        before, velocity = velocity, velocity.toward(wanted, 0.1, 0.3)
        assert abs(velocity.forward - before.forward) <= 0.1 + 1e-12
        assert abs(velocity.turn_rate - before.turn_rate) <= 0.3 + 1e-12
    assert velocity.forward == pytest.approx(wanted.forward)
    assert velocity.toward(wanted, 0.1, 0.3) == wanted


def test_only_who_does_not_move_stands() -> None:
    assert Velocity().is_standing
    assert not Velocity(0.0, 0.1).is_standing
    assert not Velocity(-0.1, 0.0).is_standing
