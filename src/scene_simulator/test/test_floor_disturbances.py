"""Each disturbance has its documented effect and counts as dirt where it hides chips."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import scene_simulator.floor.disturbances as dirt
from scene_simulator.errors import SceneError
from scene_simulator.floor.camera import Disturbance, FloorCamera, FloorPhoto
from scene_simulator.floor.dot_floor import FloorDesign, generate_dot_floor, polygon_areas
from scene_simulator.imaging.sensors import Lighting
from shirube_core.geometry import SE2

AREA = dirt.FloorArea((0.1, 0.2), (2.1, 1.2))
Scatter = Callable[[dirt.FloorArea, float, int], dirt.Litter]
KINDS: list[Scatter] = [dirt.crumbs, dirt.dust, dirt.hairs, dirt.scratches]


@pytest.mark.parametrize('kind', KINDS)
def test_litter_has_its_density_in_its_area(kind: Scatter) -> None:
    marks = kind(AREA, 800.0, 1).marks
    assert len(marks) == pytest.approx(1600, abs=5 * math.sqrt(1600))
    assert ((marks.centres >= AREA.low) & (marks.centres <= AREA.high)).all()
    assert ((marks.colours >= 0.0) & (marks.colours <= 1.0)).all()
    assert marks.opacities.max() <= 1.0


def test_dirt_in_the_picture_has_the_area_of_the_crumbs() -> None:
    floor = generate_dot_floor(FloorDesign(size=(0.4, 0.4), count=0), 1)
    litter = dirt.crumbs(dirt.FloorArea((0.18, 0.18), (0.22, 0.22)), 12_000.0, 3)
    photo = FloorCamera().photograph(floor, [SE2(0.2, 0.2, 0.0)], disturbances=[litter])
    hidden = photo.dirt.sum() * (0.13 / 339.44) ** 2
    upper = (polygon_areas(litter.marks.outlines) * litter.marks.opacities).sum()
    assert 0.8 * upper < hidden <= 1.001 * upper


@pytest.mark.parametrize('density', [-1.0, math.nan, math.inf])
def test_impossible_densities_are_refused(density: float) -> None:
    with pytest.raises(SceneError, match='scatter'):
        dirt.dust(AREA, density, 1)


FLOOR = generate_dot_floor(FloorDesign(size=(0.4, 0.4), count=860, mottling=0.0), 5)
BARE = generate_dot_floor(FloorDesign(size=(0.4, 0.4), count=0, mottling=0.0), 5)
CAMERA = FloorCamera(lighting=Lighting(gradient=(0.0, 0.0), vignetting=0.0, blur=0.0))
POSE = SE2(0.2, 0.2, 0.0)
LEFT, RIGHT = (slice(None), slice(0, 110)), (slice(None), slice(125, None))


def photo_with(*disturbances: Disturbance) -> FloorPhoto:
    return CAMERA.photograph(BARE, [POSE], disturbances=disturbances)


def brightness(photo: FloorPhoto) -> NDArray[np.float64]:
    return photo.image / CAMERA.photograph(BARE, [POSE]).image.astype(float)


@pytest.mark.parametrize(('start', 'share'), [(0.0, 20.0), (0.2, 10.0)])
def test_a_tape_hides_the_fraction_of_the_view_that_it_covers_up_to_its_end(start: float, share: float) -> None:
    photo = photo_with(dirt.Tape((0.2, start), (0.2, 0.4), 0.02))
    assert photo.dirt_fraction == pytest.approx(share / 90.0, rel=0.01)
    assert photo.image[photo.dirt == 1.0].std() == 0.0


def test_a_mat_covers_the_left_half_of_the_view() -> None:
    photo = photo_with(dirt.Tape((0.0, 0.3), (0.4, 0.3), 0.2, (0.1, 0.1, 0.1)))
    assert photo.dirt[LEFT].min() == 1.0
    assert photo.dirt[RIGHT].max() == 0.0


def test_a_shadow_darkens_its_side_and_hides_nothing() -> None:
    photo = photo_with(dirt.ShadowEdge((0.2, 0.2), math.pi / 2.0, depth=0.4))
    assert brightness(photo)[LEFT].mean() == pytest.approx(0.6, abs=0.01)
    assert brightness(photo)[RIGHT].mean() == pytest.approx(1.0)
    assert photo.dirt_fraction == 0.0


def test_a_reflection_stays_at_its_place_while_the_robot_moves() -> None:
    lamp = dirt.SpecularReflection((-0.5, 0.2), strength=1.5)
    for pose in (POSE, SE2(0.21, 0.18, 1.0)):
        photo = CAMERA.photograph(FLOOR, [pose], disturbances=[lamp])
        v, u = np.nonzero(photo.dirt)
        assert np.mean(u) == pytest.approx(117.0 - 0.5 * 117.5, abs=0.5)
        assert np.mean(v) == pytest.approx(117.0 + 0.2 * 117.5, abs=0.5)
        assert (photo.image[photo.dirt > 0] > 120).all()


def test_a_wet_spot_darkens_the_floor_within_its_radius() -> None:
    photo = photo_with(dirt.WetSpot((0.2, 0.2), radius=0.02, depth=0.3, shine=0.0))
    seen = brightness(photo)
    assert np.median(seen[110:125, 110:125]) == pytest.approx(0.7, abs=0.01)
    assert (seen[:20] == 1.0).all()
    assert (seen < 0.95).sum() == pytest.approx(math.pi * (0.02 / 0.13 * 339.44) ** 2, rel=0.2)


def test_the_rim_of_a_wet_spot_may_shine() -> None:
    dull, bright = (photo_with(dirt.WetSpot((0.2, 0.2), radius=0.02, shine=0.0, rim_shine=r)) for r in (0.0, 0.8))
    brighter = np.argwhere(bright.image.astype(int) - dull.image > 40) - 117.0
    assert len(brighter) > 100
    radii = np.hypot(*brighter.T) * 0.13 / 339.44
    assert radii.min() > 0.012
    assert radii.max() < 0.03
    assert dull.dirt_fraction < bright.dirt_fraction


def test_a_tape_under_a_moving_robot_is_where_the_middle_of_the_exposure_sees_it() -> None:
    tape = dirt.Tape((0.2, 0.0), (0.2, 0.4), 0.02)
    moving = [POSE @ SE2(0.001 * step, 0.0, 0.0) for step in (-2, -1, 0, 1, 2)]
    photo = CAMERA.photograph(BARE, moving, disturbances=[tape])
    np.testing.assert_allclose(photo.dirt, photo_with(tape).dirt, atol=1e-6)
