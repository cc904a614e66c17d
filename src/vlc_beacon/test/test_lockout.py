from vlc_beacon.core.authorization.lockout import Lockout


def test_it_closes_after_too_many_and_opens_again() -> None:
    lockout = Lockout(3, 60.0)
    for stamp in (0.0, 1.0):
        lockout.add_failure(stamp)
        assert not lockout.is_locked(stamp)
    lockout.add_failure(2.0)
    assert lockout.is_locked(2.0)
    assert lockout.is_locked(61.9)
    assert not lockout.is_locked(62.0)
    lockout.add_failure(63.0)
    assert not lockout.is_locked(63.0)


def test_few_in_a_long_time_do_not_close_it() -> None:
    lockout = Lockout(3, 60.0)
    for k in range(100):
        lockout.add_failure(31.0 * k)
        assert not lockout.is_locked(31.0 * k)


def test_guesses_are_bounded_in_any_time() -> None:
    lockout, guesses = Lockout(5, 60.0), 0
    for tenth in range(36000):
        if not lockout.is_locked(0.1 * tenth):
            lockout.add_failure(0.1 * tenth)
            guesses += 1
    assert guesses <= 5 * 61


def test_a_clock_that_is_set_back_does_not_lock_for_ever() -> None:
    lockout = Lockout(1, 60.0)
    lockout.add_failure(1e9)
    assert lockout.is_locked(1e9 + 1.0)
    assert not lockout.is_locked(5.0)
