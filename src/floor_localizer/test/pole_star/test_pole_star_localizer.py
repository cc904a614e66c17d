"""The localizer with ``matcher`` pole_star: as in the node and in ``locate``."""

from dataclasses import replace

import numpy as np
import pytest

from floor_localizer.commands.locate import make_parser
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import LocalizerSettings
from scene_simulator.floor.camera import PAPER_CAMERA
from shirube_core.geometry import SE2, CameraMount
from shirube_core.settings import SettingsError, check_settings

MOUNT = CameraMount(xyz=(0.0, 0.0, 0.13))
FLOOR = np.random.default_rng(9).uniform(0.0, 0.9, (4361, 2))  # as dense as the paper's
NOISE = 1.0  # of the paper's camera [px]


@pytest.fixture(scope='module')
def localizer() -> FloorLocalizer:
    floor = index_map(DotMap(FLOOR, np.full(len(FLOOR), np.nan)))
    return FloorLocalizer(floor, MOUNT, LocalizerSettings(matcher='pole_star'))


def dots_at(pose: SE2, floor: np.ndarray = FLOOR, missing: float = 0.1) -> DetectedDots:
    """What the camera sees there, with a pixel of noise."""
    rng = np.random.default_rng(5)
    points = pose.inverse().transform(floor)
    near = points[np.abs(points).max(axis=1) < 0.15]
    pixels = PAPER_CAMERA.pixels_from_points(MOUNT.camera_points_from_floor(near))
    inside = (pixels > 0.0).all(axis=1) & (pixels < (PAPER_CAMERA.width, PAPER_CAMERA.height)).all(axis=1)
    pixels = pixels[inside & (rng.random(len(pixels)) >= missing)]
    pixels = pixels + NOISE * rng.normal(size=pixels.shape)
    return DetectedDots(pixels, np.full(len(pixels), 8.0), np.full(len(pixels), NOISE))


@pytest.mark.parametrize('pose', [SE2(0.4, 0.5, 0.3), SE2(0.2, 0.6, -2.5), SE2(0.7, 0.25, 1.6)])
def test_the_pose_is_found_and_fitted_to_all_dots(localizer: FloorLocalizer, pose: SE2) -> None:
    found = localizer.locate_dots(dots_at(pose), PAPER_CAMERA)
    assert isinstance(found, Fix)
    assert found.T_map_base.distance_to(pose) < 0.001
    assert abs(found.T_map_base.yaw_to(pose)) < 0.01
    assert found.expected_chance_alignments < 1e-3


def test_another_floor_is_no_pose(localizer: FloorLocalizer) -> None:
    other = np.random.default_rng(77).uniform(0.0, 0.9, FLOOR.shape)
    assert isinstance(localizer.locate_dots(dots_at(SE2(0.4, 0.5, 0.3), other), PAPER_CAMERA), NoFix)


def test_the_matcher_is_searched_with_its_own_settings(localizer: FloorLocalizer) -> None:
    """A pose that the constellations find is not found by a pole star that demands too many congruent pairs."""
    settings = LocalizerSettings(matcher='pole_star')
    demanding = replace(settings, pole_star=replace(settings.pole_star, congruent_min=200))
    dots = dots_at(SE2(0.4, 0.5, 0.3))
    floor = localizer._floor
    assert isinstance(FloorLocalizer(floor, MOUNT, demanding).locate_dots(dots, PAPER_CAMERA), NoFix)
    unused = replace(demanding, matcher='constellation')
    assert isinstance(FloorLocalizer(floor, MOUNT, unused).locate_dots(dots, PAPER_CAMERA), Fix)


def test_only_known_matchers_can_be_selected(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        make_parser().parse_args(['--map', 'm', '--images', 'i', '--out', 'o', '--matcher', 'pole_star']).matcher
        == 'pole_star'
    )
    with pytest.raises(SettingsError, match='matcher'):
        check_settings(LocalizerSettings(matcher='stars'))
