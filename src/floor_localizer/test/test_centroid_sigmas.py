import numpy as np
from test_noise_removal import round_blobs

from floor_localizer.core.dot_extraction.noise_removal import centroid_sigmas


def sigmas(blobs, elongations=None, split=None):
    count = len(blobs.areas)
    elongations = np.ones(count) if elongations is None else elongations
    return centroid_sigmas(blobs, elongations, np.zeros(count, bool) if split is None else split)


def test_a_clean_round_dot_has_little_more_than_its_noise():
    blobs = round_blobs()
    assert (sigmas(blobs) > blobs.noises).all()
    assert (sigmas(blobs) < 1.5 * blobs.noises).all()


def test_with_much_noise_only_noise_counts():
    blobs = round_blobs()
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


def test_a_long_blob_larger_than_the_others_may_be_two():
    blobs = round_blobs(20)
    blobs.areas[:] *= np.linspace(0.8, 1.2, 20)
    blobs.areas[3] = 1.8 * np.pi * 9.0
    elongations = np.where(np.arange(20) == 3, 1.5, 1.1)
    assert sigmas(blobs, elongations)[3] > 1.0
    assert sigmas(blobs)[3] < 0.1


def test_where_sizes_differ_widely_no_large_dot_is_suspect():
    blobs = round_blobs(40)
    blobs.areas[:] = np.linspace(20.0, 200.0, 40)
    assert sigmas(blobs, np.full(40, 1.5)).max() < 0.1
