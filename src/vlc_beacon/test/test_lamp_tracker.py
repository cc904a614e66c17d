import math

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracker import COAST_TIME, LampTracker

RATE = 60.0
STATES = ((1.0, 1.0), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0))


def drive(levels, *, turn=0.0, noise=1.5):
    """Yield the true middle, the true levels and the samples, frame by frame."""
    rng = np.random.default_rng(1)
    detector, tracks = LampDetector(), LampTracker()
    for k, halves in enumerate(levels):
        middle = np.array([40.0 + 2.1 * k, 100.0 + 0.4 * k])
        picture = draw_lamp(room(220, 420), middle, 8.25, 180.0, halves=halves, angle=0.4 + turn * k / RATE)
        image, told = photograph(picture, noise, rng), turn / RATE if k else 0.0
        yield middle, np.array(halves), tracks.update(k / RATE, image, detector.detect(image), told)


def random_levels(count):
    rng = np.random.default_rng(1)
    levels = [STATES[k] for k in rng.integers(0, 4, count)]
    for k in rng.integers(10, count, count // 5):
        levels[k] = tuple(rng.uniform(0.0, 1.0, 2))
    return [(1.0, 1.0), *levels[1:]]


@pytest.mark.parametrize('turn', [0.0, 0.8])
def test_a_split_lamp_is_one_lamp_and_its_middle_stays_in_the_middle(turn):
    keys, errors, normalised, half_brightness = set(), [], [], []
    for k, (middle, levels, (sample,)) in enumerate(drive(random_levels(150), turn=turn)):
        keys.add(sample.key)
        if k < 30:
            continue
        heading = [math.cos(0.4 + turn * k / RATE), math.sin(0.4 + turn * k / RATE)]
        assert abs(sample.split_axis @ heading) > 0.95
        same = sample.split_axis @ heading > 0.0
        half_brightness.append((sample.half_brightness if same else sample.half_brightness[::-1]) - levels)
        if sample.is_lit:
            errors.append(sample.centre - middle)
            normalised.append(errors[-1] / sample.sigma)
    assert len(keys) == 1
    assert len(errors) > 60
    assert np.sqrt(np.mean(np.square(errors))) < 0.3
    assert np.abs(errors).max() < 1.5
    assert np.sqrt(np.mean(np.square(normalised))) < 1.3
    assert np.sqrt(np.mean(np.square(half_brightness))) < 0.03


def test_a_lamp_of_one_part_keeps_its_centroid():
    for k, (middle, _, (sample,)) in enumerate(drive([(1.0, 1.0)] * 30)):
        assert sample.centre == pytest.approx(middle, abs=0.1)
        assert sample.split_axis is None
        assert k < 20 or sample.sigma.max() < 0.1
        assert sample.half_brightness[0] == pytest.approx(sample.half_brightness[1], abs=0.05)


def test_a_dark_lamp_is_predicted_and_dropped_after_a_timeout():
    levels = [(1.0, 1.0)] * 20 + [(0.0, 0.0)] * 40
    for k, (middle, _, samples) in enumerate(drive(levels)):
        if 20 <= k < 20 + COAST_TIME * RATE - 1:
            (sample,) = samples
            assert not sample.is_lit
            assert sample.half_brightness == pytest.approx([0.0, 0.0], abs=0.05)
            assert np.hypot(*(sample.centre - middle)) < 4.0
            assert np.isinf(sample.sigma).all()
    assert samples == []


def test_faint_light_gives_no_position():
    levels = [(1.0, 1.0), (0.04, 0.01), *STATES[1:], (0.01, 0.04)] * 12
    for k, (middle, halves, (sample,)) in enumerate(drive(levels, noise=0.5)):
        if k > 30:
            assert sample.is_lit == (halves.max() > 0.5)
            assert np.hypot(*(sample.centre - middle)) < 2.0


def test_lamps_keep_their_keys_while_they_pass_over_the_image():
    rng = np.random.default_rng(2)
    detector, tracks = LampDetector(), LampTracker()
    assignments = {}
    for k in range(40):
        picture = room(300, 400)
        middles = np.array([[40.0 + 5.0 * k, 60.0], [300.0 - 5.0 * k, 90.0], [150.0, 200.0]])
        for i, middle in enumerate(middles):
            # The second is dark in every third frame.
            if i != 1 or k % 3:
                draw_lamp(picture, middle, 8.25, 150.0)
        image = photograph(picture, 1.5, rng)
        for sample in tracks.update(k / RATE, image, detector.detect(image)):
            nearest = int(np.hypot(*(middles - sample.centre).T).argmin())
            assignments.setdefault(sample.key, set()).add(nearest)
    assert sorted(map(tuple, assignments.values())) == [(0,), (1,), (2,)]
