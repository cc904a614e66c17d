"""The dead man's switch."""

import numpy as np

from shirube_view.driver import Driver


def test_whatever_pages_do_only_one_drives_and_silence_stops():
    rng = np.random.default_rng(0)
    driver, now = Driver(0.2), 0.0
    heard, owner = -1.0, None
    for _ in range(5000):
        now += rng.uniform(0.0, 0.12)
        page, choice = int(rng.integers(3)), rng.uniform()
        is_free = owner in (None, page) or now - heard > 0.2
        if choice < 0.5:
            assert (driver.drive(page, 0.5, 0.1 * page, now) == '') is is_free
            if is_free:
                owner, heard = page, now
        elif choice < 0.6:
            driver.release(page, now)
            owner = None if owner == page else owner
        if now - heard > 0.2:
            owner = None
        velocity = driver.velocity(now)
        assert velocity == ((0.5, 0.1 * owner) if owner is not None else velocity)
        assert owner is not None or velocity in (None, (0.0, 0.0))


def test_after_a_drive_zeros_are_repeated_and_then_the_topic_is_free():
    driver = Driver(0.2)
    assert driver.velocity(10.0) is None
    driver.drive('page', 1.0, 0.0, 10.0)
    assert [driver.velocity(10.0 + later) for later in (0.1, 0.21, 0.6, 0.8)] == [(1, 0), (0, 0), (0, 0), None]
