import numpy as np
import pytest

from stereo_landmark.core.primitives.quadrilateral import (
    best_corner_rotation,
    compare_corners,
    order_corner_pairs,
)

SIZE, SHAPE = np.log(1.5), 0.25


def numbers(rng, polarity=1.0):
    corners = np.array([[-30.0, -20.0], [30.0, -20.0], [30.0, 20.0], [-30.0, 20.0]]) + rng.uniform(
        -8, 8, (4, 2)
    )
    return np.array([*(corners - corners.mean(axis=0)).ravel(), polarity])


def turned(shape, steps):
    return np.array([*np.roll(shape[:8], -2 * steps), shape[8]])


def test_the_first_corner_plays_no_part():
    rng = np.random.default_rng(1)
    taught, found = numbers(rng), numbers(rng)
    plain = compare_corners(found[None], taught[None], SIZE, SHAPE)[0, 0]
    for steps in range(4):
        other = turned(found, steps)
        assert compare_corners(other[None], taught[None], SIZE, SHAPE)[0, 0] == pytest.approx(plain)
        assert turned(other, best_corner_rotation(other, taught)) == pytest.approx(
            turned(found, best_corner_rotation(found, taught))
        )


def test_differences_are_those_of_the_definition():
    """Reference implementation: the size, and the largest corner distance after scaling both to the same size."""
    rng = np.random.default_rng(2)
    found, taught = (np.array([numbers(rng) for _ in range(n)]) for n in (6, 4))
    for k, row in enumerate(compare_corners(found, taught, SIZE, SHAPE)):
        for i, difference in enumerate(row):
            one, other = found[i, :8].reshape(4, 2), taught[k, :8].reshape(4, 2)
            scale = np.linalg.norm(one) / np.linalg.norm(other)
            nearest = min(
                (np.roll(one, -s, axis=0) for s in range(4)), key=lambda c: np.linalg.norm(c - other)
            )
            shift = np.hypot(*(nearest / scale - other).T).max() / (0.5 * np.linalg.norm(other))
            assert difference == pytest.approx(max(abs(np.log(scale)) / SIZE, shift / SHAPE))


def test_another_polarity_is_infinitely_different_and_another_size_too_much():
    rng = np.random.default_rng(3)
    taught = numbers(rng)
    dark, large = taught.copy(), taught.copy()
    dark[8], large[:8] = -1.0, 2.0 * taught[:8]
    other, size = compare_corners(np.array([dark, large]), taught[None], SIZE, SHAPE)[0]
    assert np.isinf(other)
    assert size == pytest.approx(np.log(2.0) / SIZE)


def test_corners_of_both_images_come_in_the_taught_order():
    rng = np.random.default_rng(4)
    taught = numbers(rng)
    (pair,) = order_corner_pairs(turned(taught, 1)[None], turned(taught, 3)[None], taught)
    assert pair[:, :2] == pytest.approx(taught[:8].reshape(4, 2))
    assert pair[:, 2:] == pytest.approx(taught[:8].reshape(4, 2))
