from shirube_geometry import TiltTrail


def test_the_nearest_reading_counts_before_and_after() -> None:
    trail = TiltTrail()
    for k in range(50):
        trail.add(0.02 * k, 0.001 * k, -0.002 * k)
    assert trail.tilt_at(0.4) == (0.02, -0.04)
    assert trail.tilt_at(0.411) == (0.021, -0.042)
    assert trail.tilt_at(1.02) == (0.049, -0.098)


def test_an_old_reading_says_nothing() -> None:
    trail = TiltTrail()
    assert trail.tilt_at(0.0) is None
    trail.add(1.0, 0.1, 0.2)
    assert trail.tilt_at(1.05) == (0.1, 0.2)
    assert trail.tilt_at(1.2) is None
    assert trail.tilt_at(0.8) is None
