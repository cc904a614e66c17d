"""Which views of five meters are decidable, and the baselines and scores of the stereo benchmarks."""

import importlib

import numpy as np
import pytest

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_rig import StereoRig
from shirube_core.geometry import SE2, gravity_aligned_camera, matrix_from_rpy

pytestmark = pytest.mark.newest_set_only

BENCHMARK = '_five_views'
EVEN = np.array([0.0, 0.3, 0.6, 0.9, 1.2])
UNEVEN = np.array([0.0, 0.3, 0.65, 0.95, 1.33])
FORWARD_MOUNT = SE2(-3.0, 0.0, 0.0)


def everywhere(along):
    return np.ones(len(along), dtype=bool)


def decides(bench, row, hidden=(), in_view=everywhere):
    shown = in_view(row) & ~np.isin(np.arange(len(row)), hidden)
    return bench.is_spacing_unique(row, shown, in_view, 0.008)


@pytest.mark.parametrize('hidden', [1, 2, 3])
def test_an_even_row_is_decided_while_both_its_ends_are_seen(bench, hidden):
    assert decides(bench, EVEN)
    assert decides(bench, EVEN, (hidden,))


@pytest.mark.parametrize('hidden', [0, 4])
def test_an_even_row_is_not_decided_when_an_end_is_hidden_or_out_of_view(bench, hidden):
    assert not decides(bench, EVEN, (hidden,))
    assert not decides(bench, EVEN, in_view=lambda along: (along > 0.1) & (along < 2.0))


@pytest.mark.parametrize('hidden', [0, 1, 2, 3, 4])
def test_an_uneven_row_is_decided_whatever_is_hidden(bench, hidden):
    assert decides(bench, UNEVEN, (hidden,))


def test_gaps_within_the_tolerance_are_even(bench):
    rng = np.random.default_rng(1)
    assert not decides(bench, EVEN + rng.uniform(-0.003, 0.003, 5), (0,))


def test_panels_and_doors_decide_what_an_even_row_does_not(bench):
    for bare, standing in ((True, bench.UNDECIDABLE), (False, bench.DECIDABLE)):
        scene = corridor(CorridorDesign(seed=5, even=True, bare=bare))
        assert bench.classify_view(scene, (0, 1, 2, 3), 0, FORWARD_MOUNT) == standing


def test_a_robot_that_looks_aside_has_too_little_in_view(bench):
    scene = corridor(CorridorDesign(seed=5, even=True))
    aside = SE2(-2.5, 0.5, 0.4)
    assert bench.classify_view(scene, (0, 1, 2, 3), None, aside) == bench.OUT_OF_VIEW


def test_the_motion_of_the_camera_becomes_that_of_the_robot():
    peers = importlib.import_module('_stereo_peers')
    rig = peers.product_rig(StereoRig())
    pose = SE2(0.3, -0.2, 0.25)
    camera = gravity_aligned_camera(rig.mount, 0.0, 0.0)
    R_place_now = matrix_from_rpy((0.0, 0.0, pose.yaw)) @ camera.rotation
    eye = np.array([pose.x, pose.y, 0.0]) + matrix_from_rpy((0.0, 0.0, pose.yaw)) @ camera.position
    R_now_then = R_place_now.T @ camera.rotation
    shift = R_place_now.T @ (camera.position - eye)
    found = peers.planar_displacement(R_now_then, shift, rig)
    assert (found.x, found.y, found.yaw) == pytest.approx((pose.x, pose.y, pose.yaw), abs=1e-12)


def test_a_pose_half_a_spacing_off_is_a_mistake(bench):
    score = importlib.import_module('five_meters').Score()
    lesson = bench.Lesson(CorridorDesign(seed=5), (0, 1, 2, 3), (np.zeros((1, 1)), np.zeros((1, 1))))
    view = bench.MeterView(SE2(0.1, 0.0, 0.0), None, bench.DECIDABLE, lesson.pair)
    for off in (0.45, 0.55):
        score.add('SIFT', lesson, view, SE2(0.1, off * lesson.spacing, 0.0))
    score.add('SIFT', lesson, view, None)
    assert score.answers['SIFT', bench.DECIDABLE] == ['found', 'mistaken', 'none']
