"""Which blobs are dots, and how uncertain their centres are."""

import numpy as np
import pytest

from floor_localizer.core.dot_extraction.centroids import Blobs
from floor_localizer.core.dot_extraction.detector import (
    are_dots,
    blob_elongations,
    centroid_sigmas,
    excess_edge_asymmetry,
    typical_diameter,
)
from floor_localizer.core.settings import DotDetectorSettings


def round_blobs(count=12, diameter=6.0):
    return Blobs(
        pixels=np.array([[12.5 + 9.0 * i, 22.5] for i in range(count)]),
        noises=np.full(count, 0.01),
        areas=np.full(count, np.pi * diameter**2 / 4),
        covariances=np.tile([diameter**2 / 16, 0.0, diameter**2 / 16], (count, 1)),
        contrasts=np.full(count, 0.8),
        steps=np.zeros(count),
        clipped=np.zeros(count),
        softness=np.full(count, 0.8),
        edge_asymmetries=np.full(count, 0.1),
    )


def kept(blobs, **settings):
    return are_dots(blobs, blob_elongations(blobs), 25.0, DotDetectorSettings(**settings))


@pytest.mark.parametrize(('what', 'value'), [
    ('areas', 3.0), ('areas', 900.0), ('covariances', (40.0, 0.0, 1.0)), ('contrasts', 0.0),
    ('steps', 0.7), ('clipped', 0.3), ('edge_asymmetries', 2.5),
])  # fmt: skip
def test_a_blob_that_is_not_like_a_dot_is_rejected(what, value):
    blobs = round_blobs()
    getattr(blobs, what)[4] = value
    assert list(np.flatnonzero(~kept(blobs))) == [4]


def test_a_blur_common_to_all_blobs_is_no_elongation():
    blobs = round_blobs()
    stretch = np.array([[5.0, 2.0], [0.0, 1.0]])
    moments = stretch @ stretch.T
    blobs.covariances[:] = moments[0, 0], moments[0, 1], moments[1, 1]
    assert kept(blobs, maximum_elongation=3.0).all()
    assert not kept(Blobs(*(a[:4] for a in blobs)), maximum_elongation=3.0).any()


def test_round_blobs_are_dots_and_an_exposure_that_saturates_all_is_no_reflection():
    blobs = round_blobs()
    assert kept(blobs).all()
    blobs.clipped[:] = 0.6
    assert kept(blobs).all()


def test_specks_and_a_few_large_pale_spots_do_not_change_the_typical_diameter():
    dots, specks = np.full(20, np.pi * 9.0), np.full(200, np.pi * 0.25)
    assert typical_diameter(np.append(dots, specks), 3.0, 25.0) == pytest.approx(6.0)
    assert typical_diameter(np.empty(0), 3.0, 25.0) == 3.0

    areas = np.append(np.full(30, np.pi * 9.0), np.full(5, np.pi * 121.0))
    contrasts = np.append(np.full(30, 0.9), np.full(5, 0.25))
    assert typical_diameter(areas, 3.0, 25.0, contrasts) == pytest.approx(6.0)


def test_noise_and_ragged_outlines_explain_small_edge_asymmetries():
    blobs = round_blobs(3)
    blobs.edge_asymmetries[:] = 0.0, 0.27, 1.27
    np.testing.assert_allclose(excess_edge_asymmetry(blobs), [0.0, 0.0, 1.0])


def sigmas(blobs, elongations=None, split=None):
    count = len(blobs.areas)
    elongations = np.ones(count) if elongations is None else elongations
    return centroid_sigmas(blobs, elongations, np.zeros(count, bool) if split is None else split)


def test_a_clean_round_dot_has_little_more_than_its_noise_and_with_much_noise_only_noise_counts():
    blobs = round_blobs()
    assert (sigmas(blobs) > blobs.noises).all()
    assert (sigmas(blobs) < 1.5 * blobs.noises).all()
    blobs.noises[:] = 0.3
    np.testing.assert_allclose(sigmas(blobs), 0.3 * 1.04, rtol=0.01)


def test_parts_edge_asymmetries_luminance_steps_and_soft_edges_raise_the_sigma():
    split = np.arange(12) == 2
    plain = sigmas(round_blobs())[0]
    assert sigmas(round_blobs(), split=split)[2] > 5.0 * plain
    for column, value in (('edge_asymmetries', 0.6), ('steps', 0.3), ('softness', 1.6)):
        blobs = round_blobs()
        getattr(blobs, column)[2] = value
        assert np.argmax(sigmas(blobs)) == 2
        assert sigmas(blobs)[2] > 1.3 * plain


def test_a_long_blob_larger_than_the_others_may_be_two_unless_sizes_differ_widely():
    blobs = round_blobs(20)
    blobs.areas[:] *= np.linspace(0.8, 1.2, 20)
    blobs.areas[3] = 1.8 * np.pi * 9.0
    elongations = np.where(np.arange(20) == 3, 1.5, 1.1)
    assert sigmas(blobs, elongations)[3] > 1.0
    assert sigmas(blobs)[3] < 0.1
    blobs = round_blobs(40)
    blobs.areas[:] = np.linspace(20.0, 200.0, 40)
    assert sigmas(blobs, np.full(40, 1.5)).max() < 0.1
