"""The rendered picture against a projection written out by hand."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from scene_simulator.errors import SceneError
from scene_simulator.floor.camera import PAPER_CAMERA, FloorCamera
from scene_simulator.floor.dot_floor import COLOURED, DotFloor, FloorDesign, generate_dot_floor
from scene_simulator.imaging.sensors import Lighting, Sensor
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

APART = FloorDesign(size=(0.4, 0.4), count=900, min_distance=0.0075, mottling=0.0, colour_spread=0.0)
EVEN_LIGHT = Lighting(level=1.35, gradient=(0.0, 0.0), vignetting=0.0, blur=0.6)
BARREL = PinholeCamera(300, 240, 345.0, 343.0, 148.3, 121.2, (-0.25, 0.08, 0.0008, -0.0005, 0.0))
TILTED = CameraMount(xyz=(0.03, -0.02, 0.14), rpy=(math.pi + 0.03, -0.02, -1.5))
POSE = SE2(0.21, 0.19, 0.4)
FLOOR = generate_dot_floor(APART, 5)


def centroids_in(image: NDArray[np.uint8], pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the darkness-weighted centroids in discs about the true pixels."""
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    darkness = image.max() - image.astype(np.float64)
    found = []
    for pixel in pixels:
        weights = darkness * (np.hypot(u - pixel[0], v - pixel[1]) < 9.0)
        found.append([(weights * u).sum(), (weights * v).sum()] / weights.sum())
    return np.array(found)


def partly_covered(image: NDArray[np.uint8]) -> int:
    return int(((image > 30) & (image < 200)).sum())


@pytest.mark.parametrize('intrinsics', [PAPER_CAMERA, BARREL])
@pytest.mark.parametrize('mount', [CameraMount(), TILTED])
def test_every_chip_is_where_the_projection_puts_it(intrinsics: PinholeCamera, mount: CameraMount) -> None:
    camera = FloorCamera(intrinsics, EVEN_LIGHT)
    _, pixels = camera.visible_chips(FLOOR, POSE, mount)
    size = np.array([intrinsics.width, intrinsics.height])
    inner = pixels[((pixels > 11.0) & (pixels < size - 12.0)).all(axis=1)]
    image = camera.photograph(FLOOR, [POSE], mount).image
    errors = np.hypot(*(centroids_in(image, inner) - inner).T)
    assert len(inner) > 20
    assert errors.max() < 0.02


def test_the_darkness_of_the_picture_is_the_area_of_the_chips() -> None:
    one = DotFloor(APART, FLOOR.chips.select(np.array([17])), FLOOR.diameters[[17]])
    lamps = Lighting(level=1.0, gradient=(0.0, 0.0), vignetting=0.0, blur=0.0)
    over_it = SE2(*one.points[0], 0.0)
    image = FloorCamera(lighting=lamps).photograph(one, [over_it]).image.astype(float)
    ground, chip = image[0, 0], image[117, 117]
    pixels = (ground - image).sum() / (ground - chip)
    true_pixels = math.pi / 4.0 * (one.diameters[0] * 339.44 / 0.13) ** 2
    assert pixels == pytest.approx(true_pixels, rel=0.01)


def test_motion_smears_a_chip_about_the_middle_of_the_exposure() -> None:
    camera = FloorCamera(lighting=EVEN_LIGHT)
    moving = [POSE @ SE2(0.0004 * step, 0.0, 0.002 * step) for step in (-2, -1, 0, 1, 2)]
    _, pixels = camera.visible_chips(FLOOR, POSE)
    inner = pixels[((pixels > 12.0) & (pixels < 222.0)).all(axis=1)]
    sharp, smeared = (camera.photograph(FLOOR, poses).image for poses in ([POSE], moving))
    assert partly_covered(smeared) > 1.3 * partly_covered(sharp)
    assert np.hypot(*(centroids_in(smeared, inner) - inner).T).max() < 0.1


def test_noise_has_the_level_of_the_sensor_and_too_much_light_saturates() -> None:
    sensor = Sensor(full_well=4000.0, read_noise=20.0)
    flat = sensor.expose(np.full((400, 400), 0.5, dtype=np.float32), np.random.default_rng(1))
    expected = 255.0 * math.sqrt(0.5 * 4000.0 + 20.0**2) / 4000.0
    assert flat.std() == pytest.approx(expected, rel=0.02)
    assert flat.mean() == pytest.approx(127.5, abs=0.1)
    assert FloorCamera(lighting=Lighting(level=3.0)).photograph(FLOOR, [POSE]).image.max() == 255


def test_a_colour_camera_shows_the_colours() -> None:
    design = FloorDesign(size=(0.4, 0.4), count=600, chip_colours=COLOURED.chip_colours[2:3])
    floor = generate_dot_floor(design, 1)
    camera = FloorCamera(colour=True)
    _, pixels = camera.visible_chips(floor, POSE)
    image = camera.photograph(floor, [POSE]).image
    columns, rows = np.rint(pixels).astype(int).T
    blue, green, red = image[rows, columns].astype(int).T
    assert np.median(red) > 1.5 * max(np.median(green), np.median(blue))


def test_an_exposure_without_a_pose_is_refused() -> None:
    with pytest.raises(SceneError, match='pose'):
        FloorCamera().photograph(FLOOR, [])
