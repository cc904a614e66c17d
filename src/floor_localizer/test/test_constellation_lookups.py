"""Each cell is opened once, the likely ones first; the true one is among them with the expected frequency."""

import math

import numpy as np
import pytest
from six_dots import canonical_key, coordinates, six_dots

from floor_localizer.core.constellation.constellation_index import build_constellation_index
from floor_localizer.core.constellation.constellation_key import INNER_DOTS, bucket_of_hash, hash_cell, pack_subcell
from floor_localizer.core.constellation.constellation_lookups import (
    ProbabilityRange,
    add_constellation,
    allocate_lookups,
    is_compatible,
    is_full,
    key_coordinates,
)
from floor_localizer.core.constellation.dot_grid import build_dot_grid

NOISE = 0.014
INDEX = build_constellation_index(build_dot_grid(np.random.default_rng(0).uniform(size=(600, 2)))[0])


def key_of(dots):
    """The subcell of six dots in canonical form, their bucket, and their coordinates."""
    steps, xy, _ = canonical_key(dots, INDEX.step)
    bucket = bucket_of_hash(np.uint64(hash_cell(steps)), len(INDEX.starts) - 1)
    return np.uint64(pack_subcell(steps)), bucket, xy


def make_lookups(dots, minimum, maximum=math.inf, noise=NOISE, lookups=None):
    lookups, wanted = lookups or allocate_lookups(), ProbabilityRange(minimum, maximum)
    add_constellation(INDEX, lookups, np.arange(6), coordinates(dots), noise, wanted)
    return lookups


def buckets_of(lookups):
    return lookups.buckets[: lookups.counts[1]].tolist()


def is_opened(lookups, subcell, bucket, xy):
    """Whether the bucket of a key is opened for the key's cell, and the key is within the gate."""
    found = np.empty((INNER_DOTS, 2))
    for lookup, opened in enumerate(buckets_of(lookups)):
        if opened == bucket and is_compatible(lookups, lookup, subcell):
            key_coordinates(lookups, lookup, subcell, INDEX.step, found)
            if np.max(np.abs(found - xy)) <= 0.501 * INDEX.step:
                return True
    return False


@pytest.mark.parametrize('seed', range(20))
def test_without_noise_the_home_cell_is_opened(seed):
    dots = six_dots(np.random.default_rng(seed))
    assert is_opened(make_lookups(dots, 0.3, noise=1e-5), *key_of(dots))


def test_the_likely_cells_include_the_true_one_nine_times_of_ten_and_more_often_than_others():
    rng = np.random.default_rng(2)
    found, opened, hits = [], np.zeros(3), np.zeros(3)
    for _ in range(500):
        dots = six_dots(rng)
        noisy, key = dots + rng.normal(0.0, NOISE, dots.shape), key_of(dots)
        found.append(is_opened(make_lookups(noisy, 0.001), *key))
        for k, probability_range in enumerate([(0.1, math.inf), (0.01, 0.1), (0.001, 0.01)]):
            lookups = make_lookups(noisy, *probability_range)
            opened[k] += lookups.counts[1]
            hits[k] += is_opened(lookups, *key)
    assert np.mean(found) > 0.85
    hit_rates = hits / opened
    assert hit_rates[0] > 0.1
    assert 0.01 < hit_rates[1] < 0.1
    assert hit_rates[2] < 0.01


@pytest.mark.parametrize('seed', range(5))
def test_rounds_open_together_what_one_opens_and_nothing_twice(seed):
    dots = six_dots(np.random.default_rng(seed))
    rounds = [(0.1, math.inf), (0.02, 0.1), (0.004, 0.02)]
    apart = [bucket for each in rounds for bucket in buckets_of(make_lookups(dots, *each))]
    assert sorted(apart) == sorted(buckets_of(make_lookups(dots, 0.004)))


def test_seeds_go_along_with_their_coordinates():
    dots = six_dots(np.random.default_rng(3))
    lookups = make_lookups(dots, 0.001)
    for slot in range(lookups.counts[0]):
        seeds = lookups.seeds[slot]
        np.testing.assert_allclose(lookups.xy[slot], coordinates(dots, *seeds), atol=1e-12)


def test_any_constellation_fits_until_the_lookups_are_full():
    rng = np.random.default_rng(4)
    lookups = allocate_lookups()
    while not is_full(lookups):
        make_lookups(six_dots(rng), 1e-3, lookups=lookups)
    assert lookups.counts[0] <= len(lookups.noise)
    assert lookups.counts[1] <= len(lookups.buckets)
