from shirube_geometry import TiltTrail


def test_the_reading_nearest_to_a_time_counts():
    trail = TiltTrail()
    for number in range(5):
        trail.add(0.1 * number, 0.01 * number, -0.01 * number)
    assert trail.tilt_at(0.21) == (0.02, -0.02)
    assert trail.tilt_at(0.45) == (0.04, -0.04)


def test_without_a_reading_near_the_tilt_is_not_known():
    trail = TiltTrail()
    assert trail.tilt_at(0.0) is None
    trail.add(1.0, 0.1, 0.2)
    assert trail.tilt_at(1.2) is None
    assert trail.tilt_at(0.95) == (0.1, 0.2)
