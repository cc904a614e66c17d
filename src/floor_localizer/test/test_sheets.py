"""Levels of a map do not overlap, and poses are transformed there and back."""

from __future__ import annotations

import itertools

import pytest

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.sheets import lay_out_sheets, sheet_of
from shirube_geometry import PlanarPose

CORNERS = [(-3.5, 2.0, 7.1, 9.0), (0.0, 0.0, 12.0, 4.0), (100.0, -80.0, 101.0, -70.0)]
SHEETS = lay_out_sheets(['cellar', 'ground', 'roof'], CORNERS)


def test_sheets_lie_apart():
    for one, other in itertools.combinations(SHEETS, 2):
        gaps = [
            max(other.lower[axis] - one.upper[axis], one.lower[axis] - other.upper[axis]) for axis in range(2)
        ]
        assert max(gaps) >= 1.0


def test_corners_are_those_of_the_floor_in_its_own_frame():
    for sheet, corners in zip(SHEETS, CORNERS, strict=True):
        lower = sheet.pose_on_sheet(PlanarPose(*sheet.lower, 0.0))
        upper = sheet.pose_on_sheet(PlanarPose(*sheet.upper, 0.0))
        assert (lower.x, lower.y, upper.x, upper.y) == pytest.approx(corners)


def test_a_pose_comes_back_from_the_map():
    pose = PlanarPose(1.25, 3.5, 2.0)
    for sheet in SHEETS:
        assert sheet.pose_on_sheet(sheet.pose_on_map(pose)) == pose


def test_a_place_is_on_the_sheet_that_it_lies_on_or_next_to():
    for sheet in SHEETS:
        middle = [(a + b) / 2.0 for a, b in zip(sheet.lower, sheet.upper, strict=True)]
        assert sheet_of(SHEETS, *middle) == sheet
        assert sheet_of(SHEETS, sheet.lower[0] - 0.1, sheet.lower[1] - 0.1) == sheet
    assert sheet_of((), 1.0, 2.0) is None


def test_sheets_too_large_for_single_precision_are_refused():
    with pytest.raises(FloorLocalizerError, match='make several maps'):
        lay_out_sheets(['a', 'b'], [(0.0, 0.0, 700.0, 10.0)] * 2)
