"""Each cell is opened once, the likely ones first; the true one is among them with the expected frequency."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floor_localizer.core.constellation.constellation_index import build_constellation_index
from floor_localizer.core.constellation.constellation_key import (
    LANES,
    OTHERS,
    base_coordinates,
    bucket_of_hash,
    cut_into_steps,
    hash_of_steps,
    imbalance,
    pack_parts,
    sort_by_x,
    turn_around,
)
from floor_localizer.core.constellation.constellation_lookups import (
    Wanted,
    add_constellation,
    fits,
    is_full,
    key_coordinates,
    no_lookups,
)
from floor_localizer.core.constellation.dot_grid import build_dot_grid

NOISE = 0.014
INDEX = build_constellation_index(build_dot_grid(np.random.default_rng(0).uniform(size=(600, 2)))[0])


def six_dots(rng):
    return np.vstack([[[0.0, 0.0], [1.0, 0.0]], rng.uniform((0.1, -0.5), (0.9, 0.5), (OTHERS, 2))])


def coordinates(dots):
    xy = np.empty((OTHERS, 2))
    base_coordinates(dots, 0, 1, np.arange(2, 6), xy)
    return xy


def key_of(dots):
    """The subcell of six dots in canonical form, their bucket, and their coordinates."""
    xy = coordinates(dots)
    if imbalance(xy) > 0.0:
        turn_around(xy)
    sort_by_x(xy)
    steps = np.empty(LANES, dtype=np.int64)
    cut_into_steps(xy, INDEX.step, steps)
    bucket = bucket_of_hash(np.uint64(hash_of_steps(steps)), len(INDEX.starts) - 1)
    return np.uint64(pack_parts(steps)), bucket, xy


def lookups_of(dots, least, below=math.inf, noise=NOISE):
    lookups = no_lookups()
    add_constellation(INDEX, lookups, np.arange(6), coordinates(dots), noise, Wanted(least, below))
    return lookups


def buckets_of(lookups):
    return lookups.buckets[: lookups.counts[1]].tolist()


def is_opened(lookups, parts, bucket, xy):
    """Whether the bucket of a key is opened for the key's cell, and the key is within the gate."""
    found = np.empty((OTHERS, 2))
    for lookup, opened in enumerate(buckets_of(lookups)):
        if opened == bucket and fits(lookups, lookup, parts):
            key_coordinates(lookups, lookup, parts, INDEX.step, found)
            if np.max(np.abs(found - xy)) <= 0.501 * INDEX.step:
                return True
    return False


@pytest.mark.parametrize('seed', range(20))
def test_without_noise_the_cell_at_home_is_opened(seed):
    dots = six_dots(np.random.default_rng(seed))
    assert is_opened(lookups_of(dots, 0.3, noise=1e-5), *key_of(dots))


def test_in_all_likely_cells_the_true_one_is_found_nine_times_of_ten():
    rng = np.random.default_rng(1)
    found = []
    for _ in range(500):
        dots = six_dots(rng)
        noisy = dots + rng.normal(0.0, NOISE, dots.shape)
        found.append(is_opened(lookups_of(noisy, 0.001), *key_of(dots)))
    assert np.mean(found) > 0.85


def test_likely_cells_hold_the_true_one_more_often_than_others():
    rng = np.random.default_rng(2)
    opened, held = np.zeros(3), np.zeros(3)
    for _ in range(400):
        dots = six_dots(rng)
        noisy = dots + rng.normal(0.0, NOISE, dots.shape)
        for k, wanted in enumerate([(0.1, math.inf), (0.01, 0.1), (0.001, 0.01)]):
            lookups = lookups_of(noisy, *wanted)
            opened[k] += lookups.counts[1]
            held[k] += is_opened(lookups, *key_of(dots))
    share = held / opened
    assert share[0] > 0.1
    assert 0.01 < share[1] < 0.1
    assert share[2] < 0.01


@pytest.mark.parametrize('seed', range(5))
def test_rounds_open_together_what_one_opens_and_nothing_twice(seed):
    dots = six_dots(np.random.default_rng(seed))
    rounds = [(0.1, math.inf), (0.02, 0.1), (0.004, 0.02)]
    apart = [bucket for wanted in rounds for bucket in buckets_of(lookups_of(dots, *wanted))]
    assert sorted(apart) == sorted(buckets_of(lookups_of(dots, 0.004)))


def test_seeds_go_along_with_their_coordinates():
    dots = six_dots(np.random.default_rng(3))
    lookups = lookups_of(dots, 0.001)
    for form in range(lookups.counts[0]):
        seeds = lookups.seeds[form]
        xy = np.empty((OTHERS, 2))
        base_coordinates(dots, seeds[0], seeds[1], seeds[2:], xy)
        np.testing.assert_allclose(lookups.xy[form], xy, atol=1e-12)


def test_there_is_room_for_any_constellation_until_it_is_full():
    rng = np.random.default_rng(4)
    lookups = no_lookups()
    while not is_full(lookups):
        add_constellation(
            INDEX, lookups, np.arange(6), coordinates(six_dots(rng)), NOISE, Wanted(1e-3, math.inf)
        )
    assert lookups.counts[0] <= len(lookups.noise)
    assert lookups.counts[1] <= len(lookups.buckets)
