from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.acceptance import new_search
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.constellation.pair_search import search_pairs
from floor_localizer.core.dots import make_view
from floor_localizer.core.mat.page_layout import Mat, MatSettings, generate_mat

SETTINGS = MatSettings(width=0.3, height=0.2)


def is_match(mat: Mat, other: Mat) -> bool:
    """Return whether the centre of one mat is found anywhere on the other, by trying all pairs."""
    middle = mat.points[np.abs(mat.points - (0.15, 0.1)).max(axis=1) < 0.05]
    floor = index_map(other.dot_map)
    view = make_view(middle, 0.0001, 0.0, 0.05, floor.density)
    search = new_search(len(middle), float(len(other.points)), 1e-3, 0.25)
    return search_pairs(floor.grid, floor.addresses, view, search, 60)


def test_dots_keep_their_distance_and_stay_on_the_mat():
    mat = generate_mat(SETTINGS, 1)
    assert len(mat.points) == 300
    assert cKDTree(mat.points).query(mat.points, k=2)[0][:, 1].min() >= SETTINGS.spacing
    assert mat.points.min() >= SETTINGS.diameter / 2
    assert (mat.points <= np.array([0.3, 0.2]) - SETTINGS.diameter / 2).all()


def test_dots_are_spread_evenly():
    mat = generate_mat(replace(SETTINGS, width=1.0, height=1.0), 4)
    counts = np.histogram2d(*mat.points.T, bins=4, range=[[0, 1], [0, 1]])[0]
    # 312 a cell; without clumps its deviation is below Poisson's 18.
    assert np.abs(counts - counts.mean()).max() < 60


@pytest.mark.parametrize('seed', [2, 3, 4])
def test_two_mats_never_match(seed):
    mat = generate_mat(SETTINGS, 1)
    assert is_match(mat, mat)
    assert not is_match(mat, generate_mat(SETTINGS, seed))


@pytest.mark.parametrize('change', [{'width': 0.31}, {'diameter': 0.0024}, {'density': 4999.0}])
def test_mats_of_different_sizes_do_not_match(change):
    assert not is_match(generate_mat(SETTINGS, 1), generate_mat(replace(SETTINGS, **change), 1))
