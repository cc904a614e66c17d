"""The order of the procedure tree, its windows, and its combinations (paper 3.4, figs 7 and 8)."""

import numpy as np
import pytest

from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.procedure_tree import GROWTH, GROWTH_FIRST, Detection, ProcedureTree
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives
from stereo_landmark.core.settings import SearchSettings

CENTRES = np.array([[100.0, 100.0], [200.0, 100.0], [300.0, 120.0]])
SETTINGS = SearchSettings()


def circle(radius):
    return Ellipse(np.zeros(2), np.full(2, radius), 0.0, -1, 1.0, np.zeros((5, 5)))


class Detector:
    """Detections of each primitive at given centres; records what is searched."""

    def __init__(self, *centres, size=10.0):
        self.windows = []
        self.detections = [
            [
                Detection(
                    DetectedPrimitives(PrimitiveKind.ELLIPSE, (circle(size),)),
                    *(0, np.zeros(2), complex(*centre), size, misfit),
                )
                for centre, misfit in places
            ]
            for places in centres
        ]

    def find(self, index, centre=0.0j, radius=np.inf):
        self.windows.append((index, centre, radius))
        return [each for each in self.detections[index] if abs(each.centre - centre) <= radius]


def exact(*indices):
    """Return primitives that are seen where they were taught."""
    return [[(CENTRES[k], 0.0)] if k in indices else [] for k in range(3)]


def search(detector, first=0):
    return ProcedureTree(detector, [circle(10.0)] * 3, CENTRES, SETTINGS).search(first)


def test_the_surest_primitive_is_searched_first_and_the_others_in_their_order():
    detector = Detector(*exact(0, 1, 2))
    (found,) = search(detector)
    assert list(found.found) == [0, 1, 2]
    assert [index for index, *_ in detector.windows] == [0, 1, 2]
    assert found.misfit == pytest.approx(0.0)


def test_the_next_branch_is_followed_without_a_candidate_and_the_skipped_one_searched_again():
    """a, e, l of figure 7: P1, then P3, because P2 is not in its window; then P2 in a smaller one."""
    detector = Detector([(CENTRES[0], 0.0)], [((200.0, 135.0), 0.0)], [(CENTRES[2], 0.0)])
    (found,) = search(detector)
    assert [index for index, *_ in detector.windows] == [0, 1, 2, 1]
    assert list(found.found) == [0, 2]
    assert detector.windows[3][2] < detector.windows[1][2]


def test_a_path_may_begin_with_any_primitive():
    assert search(Detector(*exact(1, 2))) == []
    detector = Detector(*exact(1, 2))
    (found,) = search(detector, 1)
    assert list(found.found) == [1, 2]
    assert [index for index, *_ in detector.windows] == [1, 0, 2, 0]
    assert search(Detector(*exact(2)), 2) == []


def test_windows_are_where_the_primitives_found_before_predict():
    """One primitive twice as large doubles distances; two of them also give the rotation."""
    grown = 50.0 + 2.0 * CENTRES
    detector = Detector(*[[(centre, 0.0)] for centre in grown], size=20.0)
    search(detector)
    _, (_, centre, radius), _ = detector.windows
    assert centre == pytest.approx(complex(*grown[1]))
    assert radius == pytest.approx(SETTINGS.window + GROWTH_FIRST * 200.0)
    turned = CENTRES @ np.array([[np.cos(0.1), np.sin(0.1)], [-np.sin(0.1), np.cos(0.1)]])
    detector = Detector(*[[(centre, 0.0)] for centre in turned])
    search(detector)
    _, _, (_, centre, radius) = detector.windows
    assert centre == pytest.approx(complex(*turned[2]))
    step = np.linalg.norm(CENTRES[2] - CENTRES[:2].mean(axis=0))
    assert radius == pytest.approx(SETTINGS.window + GROWTH * step)


def test_of_the_combinations_the_fullest_and_nearest_is_the_first():
    first, second, third = ([(centre, 0.0)] for centre in CENTRES)
    second += [((200.0, 112.0), 0.0), ((200.0, 101.0), 0.5)]
    found = search(Detector([((400.0, 400.0), 0.0), *first], second, third))
    assert [len(each.found) for each in found] == [3, 3]
    assert found[0].found[1].centre == 200.0 + 100.0j
    assert [each.misfit for each in found] == sorted(each.misfit for each in found)
    assert found[0].misfit == pytest.approx(0.0, abs=1e-9)
