import numpy as np
import pytest

from floor_localizer.core.dot_extraction.distance_watershed import distance_watershed


def raster_of(*discs, size=64):
    y, x = np.mgrid[:size, :size]
    return np.any([np.hypot(x - u, y - v) < r for u, v, r in discs], axis=0).astype(np.uint8)


def basins_of(raster, thin=0.4, waist=0.88, radius=3.0):
    return distance_watershed(raster, thin, waist, radius)


@pytest.mark.parametrize('corners', [3, 4, 5, 8])
@pytest.mark.parametrize('turn', [0.0, 0.4])
def test_a_convex_shape_stays_whole(corners, turn):
    y, x = np.mgrid[:64, :64] - 32.0
    angles = turn + 2.0 * np.pi * np.arange(corners) / corners
    inside = np.all([x * np.cos(a) + y * np.sin(a) < 13.0 for a in angles], axis=0)
    basins, count = basins_of(inside.astype(np.uint8))
    assert count == 1
    assert (basins[~inside] == 0).all()


@pytest.mark.parametrize('turn', [0.0, 0.5, 1.1])
@pytest.mark.parametrize(('first', 'second'), [(10.0, 10.0), (12.0, 8.0)])
def test_two_touching_discs_part_at_their_waist(turn, first, second):
    direction = np.array([np.cos(turn), np.sin(turn)])
    a, b = 32.0 - second * direction, 32.0 + first * direction
    raster = raster_of((*a, first + 0.5), (*b, second + 0.5))
    basins, count = basins_of(raster)
    assert count == 2
    one, two = basins[round(a[1]), round(a[0])], basins[round(b[1]), round(b[0])]
    assert {one, two} == {1, 2}
    areas = np.bincount(basins.ravel(), minlength=3)
    assert areas[one] == pytest.approx(np.pi * first**2, rel=0.15)
    assert areas[two] == pytest.approx(np.pi * second**2, rel=0.15)


def test_a_hair_is_left_out_of_the_basin():
    raster = raster_of((32, 32, 9.0))
    raster[31:34, 4:60] = 1
    basins, count = basins_of(raster)
    assert count == 1
    assert (basins[:, :20] == 0).all()
    assert (basins[:, 45:] == 0).all()
    assert basins[32, 32] == 1
    # Nor does it hold two discs together.
    raster = raster_of((14, 32, 8.0), (50, 32, 8.0))
    raster[31:34, 10:54] = 1
    basins, count = basins_of(raster)
    assert count == 2
    assert basins[32, 32] == 0


def test_small_parts_and_wide_waists_do_not_count():
    raster = raster_of((25, 32, 10.0), (38, 32, 8.0))
    assert basins_of(raster, radius=9.0)[1] == 1
    assert basins_of(raster, waist=0.5)[1] == 1
    assert basins_of(raster)[1] == 2
