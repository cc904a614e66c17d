from shirube_core.geometry import TiltBuffer


def test_the_nearest_reading_counts_before_and_after() -> None:
    buffer = TiltBuffer()
    for k in range(50):
        buffer.add(0.02 * k, 0.001 * k, -0.002 * k)
    assert buffer.tilt_at(0.4) == (0.02, -0.04)
    assert buffer.tilt_at(0.411) == (0.021, -0.042)
    assert buffer.tilt_at(1.02) == (0.049, -0.098)


def test_an_old_reading_says_nothing() -> None:
    buffer = TiltBuffer()
    assert buffer.tilt_at(0.0) is None
    buffer.add(1.0, 0.1, 0.2)
    assert buffer.tilt_at(1.05) == (0.1, 0.2)
    assert buffer.tilt_at(1.2) is None
    assert buffer.tilt_at(0.8) is None
