from shirube_core.geometry import TiltBuffer


def test_the_nearest_reading_counts_and_an_old_one_does_not() -> None:
    buffer = TiltBuffer()
    assert buffer.tilt_at(0.0) is None
    for k in range(50):
        buffer.add(0.02 * k, 0.001 * k, -0.002 * k)
    assert buffer.tilt_at(0.4) == (0.02, -0.04)
    assert buffer.tilt_at(0.411) == (0.021, -0.042)
    assert buffer.tilt_at(1.02) == (0.049, -0.098)
    assert buffer.tilt_at(1.03) == (0.049, -0.098)
    assert buffer.tilt_at(1.2) is None
    assert buffer.tilt_at(-0.2) is None
