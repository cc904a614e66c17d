"""Laws of rendered lamps: place, size, light over time, motion, saturation."""

import math

import numpy as np
import pytest

from scene_simulator.ceiling.camera import PAPER_OPTICS, UPWARD_MOUNT, CeilingCamera, CeilingPhoto
from scene_simulator.ceiling.lamp import CeilingLamp, Disc
from scene_simulator.ceiling.lens import SHARP, Blooming, CeilingLens
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.imaging.exposure import CameraPose, PoseAt, Shutter, camera_pose
from scene_simulator.imaging.sensors import GainSensor
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.waveform import Waveform, waveform_from_steps

SMALL = PinholeCamera(200, 160, 636.4, 636.4, 99.5, 79.5)
BENT = PinholeCamera(640, 512, 318.0, 320.0, 322.1, 250.3, (-0.1, 0.01, 0.0008, -0.0005, 0.0))
EVEN_TO_DIM = CeilingLens(vignetting=0.4).transmission(SMALL)
TILTED = CameraMount((0.0, 0.0, 0.0), (0.06, -0.04, math.pi / 2.0 + 0.2))
UNEVEN = waveform_from_steps([0.7e-3, 0.2e-3, 1.1e-3, 0.5e-3], [1.0, 0.25, 0.0, 0.6])
OVERHEAD = (0.0, 0.0, 2.5)


def resting(_: float) -> CameraPose:
    return camera_pose(SE2(0.0, 0.0, 0.0), UPWARD_MOUNT)


def moving(vx: float, vy: float, mount: CameraMount = UPWARD_MOUNT) -> PoseAt:
    return lambda time: camera_pose(SE2(vx * time, vy * time, 0.0), mount)


def camera(shutter: Shutter | None = None, intrinsics: PinholeCamera = SMALL) -> CeilingCamera:
    return CeilingCamera(intrinsics, shutter or Shutter(), CeilingLens(0.0, blooming=SHARP))


def room_with(xyz: tuple[float, float, float], radius: float = 0.0325, *waveform: Waveform) -> CeilingRoom:
    return CeilingRoom((CeilingLamp(xyz, Disc(radius), *waveform),))


def centroid(light: np.ndarray) -> np.ndarray:
    v, u = np.mgrid[: light.shape[0], : light.shape[1]]
    weights = light.astype(float)
    return np.array([(weights * u).sum(), (weights * v).sum()]) / weights.sum()


def centroid_near(photo: CeilingPhoto, seen: tuple[float, float]) -> np.ndarray:
    """Return the intensity centroid of an image in a square about a pixel."""
    left, top = (round(middle) - 45 for middle in seen)
    window = photo.image[top : top + 91, left : left + 91]
    return np.array([left, top]) + centroid(window)


@pytest.mark.parametrize('blooming', [SHARP, Blooming()])
@pytest.mark.parametrize('radius', [0.006, 0.0325])
@pytest.mark.parametrize('x', np.linspace(-0.9, 0.9, 5))
def test_a_disc_is_where_the_pinhole_projects_it(blooming: Blooming, radius: float, x: float) -> None:
    lens = CeilingLens(0.0, blooming=blooming)
    taken = CeilingCamera(PAPER_OPTICS, lens=lens, sensor=GainSensor(black_level=0.0))
    lamp = CeilingLamp((x, 0.6 * x + 0.0123, 2.5), Disc(radius), brightness=taken.brightness_for(0.98))
    photo = taken.photograph(CeilingRoom((lamp,)), resting, 0.0)
    # The camera looks up with its upper edge ahead: y of the map, which is left, is right in the image.
    hand_written = (639.5 + 636.4 * lamp.xyz[1] / 2.5, 511.5 - 636.4 * lamp.xyz[0] / 2.5)
    found = centroid_near(photo, hand_written)
    assert math.dist(found, hand_written) < 0.02
    assert math.dist(photo.lamp_projections[0].centre, hand_written) < 1e-6


@pytest.mark.parametrize('blooming', [SHARP, Blooming()])
@pytest.mark.parametrize('place', [(0.0, 0.0), (1.1, 0.6), (-0.9, 1.2), (0.3, -1.4)])
def test_with_a_bent_lens_and_tilt_a_disc_is_at_the_centroid_of_its_outline(
    place: tuple[float, float], blooming: Blooming
) -> None:
    taken = CeilingCamera(BENT, lens=CeilingLens(0.0, blooming=blooming))
    room = CeilingRoom((CeilingLamp((*place, 2.5), Disc(0.05), brightness=taken.brightness_for(1.0)),))
    robot = camera_pose(SE2(0.02, -0.03, 0.4), TILTED)
    (seen,) = taken.photograph(room, lambda _: robot, 0.0).lamp_projections
    assert math.dist(centroid(taken.light(room, lambda _: robot, 0.0)), seen.centroid) < 0.02


@pytest.mark.parametrize('z', [1.5, 2.5, 4.0])
@pytest.mark.parametrize('spread', [0.0, 2.5])
def test_the_half_brightness_has_the_size_of_the_distance_and_the_spread(z: float, spread: float) -> None:
    lens = CeilingLens(0.0, blooming=Blooming(2.4, spread, 0.0))
    taken = CeilingCamera(SMALL, lens=lens)
    lamp = CeilingLamp((0.0, 0.0, z), Disc(0.0325), brightness=taken.brightness_for(1.0))
    light = taken.light(CeilingRoom((lamp,)), resting, 0.0)
    fine = np.interp(np.arange(99.5, 199.0, 0.001), np.arange(200), 0.5 * (light[79] + light[80]))
    # Rows 79 and 80 are half a pixel off the middle.
    half = math.hypot(0.001 * np.argmax(fine < 0.5), 0.5)
    assert half == pytest.approx(636.4 * 0.0325 / z + spread, abs=0.05)


def test_exposures_that_follow_each_other_keep_the_light_of_the_waveform() -> None:
    room = CeilingRoom((CeilingLamp(OVERHEAD, waveform=UNEVEN, phase=0.3e-3),))
    quarter, whole = camera(Shutter(UNEVEN.period / 4.0)), camera(Shutter(UNEVEN.period))
    pieces = sum(quarter.light(room, resting, 0.01 + i * UNEVEN.period / 4.0) for i in range(4))
    together = whole.light(room, resting, 0.01)
    np.testing.assert_allclose(pieces, together, atol=1e-5)
    mean = np.diff([*UNEVEN.times, UNEVEN.period]) @ UNEVEN.levels[:, 0] / UNEVEN.period
    steady = whole.light(CeilingRoom((CeilingLamp(OVERHEAD),)), resting, 0.01)
    assert together.sum() == pytest.approx(mean * steady.sum(), rel=1e-5)


@pytest.mark.parametrize('stamp', [0.0, 0.55e-3, 4.321])
@pytest.mark.parametrize('shutter', [Shutter(0.4e-3), Shutter(60e-6, 18e-6)])
def test_rows_show_the_levels_of_a_lamp_and_of_a_flickering_ceiling_at_their_own_time(
    shutter: Shutter, stamp: float
) -> None:
    starts = stamp + shutter.row_time * np.arange(160)
    levels = UNEVEN.mean_levels(starts, starts + shutter.exposure)
    assert np.ptp(levels) > 0.9 or not shutter.row_time
    dark = CeilingRoom((CeilingLamp(OVERHEAD, brightness=0.0),))
    for steady, blinking in (
        (room_with(OVERHEAD, 0.2), room_with(OVERHEAD, 0.2, UNEVEN)),
        (dark.with_ambient_light(1000.0), dark.with_ambient_light(1000.0, flicker=UNEVEN)),
    ):
        expected, seen = (camera(shutter).light(room, resting, stamp) for room in (steady, blinking))
        np.testing.assert_allclose(seen, levels * expected, rtol=1e-4, atol=1e-6)


def test_the_halves_of_a_panel_show_their_own_levels() -> None:
    halves = waveform_from_steps([1e-3, 1e-3], [[1.0, 0.3], [0.2, 0.6]])
    lamp = CeilingLamp(OVERHEAD, Disc(0.08), halves)
    taken = camera(Shutter(0.5e-3))
    light = taken.light(CeilingRoom((lamp,)), resting, 1.25e-3) / (lamp.brightness * 0.5e-3)
    # The first half has negative x: behind the robot, which is below in the image.
    assert light[79 + 10, 99] == pytest.approx(0.2, abs=1e-3)
    assert light[79 - 10, 99] == pytest.approx(0.6, abs=1e-3)


def test_a_moving_camera_shears_a_rolling_image() -> None:
    row_time, speed = 18e-6, 4.0
    # Upwards with the upper edge ahead: driving to the left moves lamps to the left of the image.
    room = room_with((0.0, speed * 80 * row_time, 2.5), 0.1)
    light = camera(Shutter(20e-6, row_time)).light(room, moving(0.0, speed), 0.0)
    rows = np.arange(60, 100)
    middles = light[rows] @ np.arange(200) / light[rows].sum(axis=1)
    slope = np.polyfit(rows, middles, 1)[0]
    assert slope == pytest.approx(-636.4 / 2.5 * speed * row_time, rel=0.01)


@pytest.mark.parametrize(('row_time', 'speed', 'radius'), [(18e-6, 10.0, 0.05), (40e-6, 15.0, 0.2)])
def test_a_camera_that_drives_along_its_columns_stretches_a_rolling_image(
    row_time: float, speed: float, radius: float
) -> None:
    taken = camera(Shutter(20e-6, row_time))
    light = taken.light(room_with((speed * 80 * row_time, 0.0, 2.5), radius), moving(speed, 0.0), 0.0)
    at_rest = taken.light(room_with(OVERHEAD, radius), resting, 0.0)
    down = 636.4 / 2.5 * speed * row_time  # how far lamps run down while the read-out goes one row down [px]
    assert light.sum() / at_rest.sum() == pytest.approx(1.0 / (1.0 - down), rel=1e-3)


def test_motion_in_the_exposure_smears_a_lamp_about_the_middle() -> None:
    exposure, speed = 8e-3, 5.0
    room, taken = room_with((0.5 * speed * exposure, 0.0, 2.5), 0.02), camera(Shutter(exposure))
    light = taken.light(room, moving(speed, 0.0), 0.0)
    at_rest = taken.light(room_with(OVERHEAD, 0.02), resting, 0.0)
    assert light.sum() == pytest.approx(at_rest.sum(), rel=1e-3)
    np.testing.assert_allclose(centroid(light), [99.5, 79.5], atol=0.01)
    squares = np.square(np.arange(160) - 79.5)
    spread, spread_at_rest = (x.sum(axis=1) @ squares / x.sum() for x in (light, at_rest))
    smear = 636.4 / 2.5 * speed * exposure
    assert spread - spread_at_rest == pytest.approx(smear**2 / 12.0, rel=0.01)
    photo = taken.photograph(room, moving(speed, 0.0), 0.0)
    assert photo.middle == pytest.approx(0.5 * exposure)
    np.testing.assert_allclose(photo.pose.position, [0.5 * speed * exposure, 0.0, 0.0], atol=1e-12)


def test_a_blink_during_the_motion_is_frozen_in_its_place() -> None:
    exposure, speed = 8e-3, 5.0
    flash = waveform_from_steps([6e-3, 0.2e-3, 1.8e-3], [0.0, 1.0, 0.0])
    room = room_with((0.5 * speed * exposure, 0.0, 2.5), 0.02, flash)
    light = camera(Shutter(exposure)).light(room, moving(speed, 0.0), 0.0)
    flown = 636.4 / 2.5 * speed * (6.1e-3 - 0.5 * exposure)
    np.testing.assert_allclose(centroid(light), [99.5, 79.5 + flown], atol=0.3)


def test_vignetting_dims_a_lamp_and_the_ceiling_equally() -> None:
    corner = (75 * 2.5 / 636.4, -95 * 2.5 / 636.4, 2.5)
    room = CeilingRoom((CeilingLamp(corner),)).with_ambient_light(100.0)
    dimmed = CeilingCamera(SMALL, lens=CeilingLens(0.4, blooming=SHARP)).light(room, resting, 0.0)
    np.testing.assert_allclose(dimmed, EVEN_TO_DIM * camera().light(room, resting, 0.0), rtol=1e-5)


def test_an_overexposed_lamp_saturates_and_looks_larger() -> None:
    sizes = []
    for level in (0.5, 1.0, 4.0):
        taken = CeilingCamera(SMALL, lens=CeilingLens(0.0), sensor=GainSensor(black_level=0.0))
        lamp = CeilingLamp(OVERHEAD, brightness=taken.brightness_for(level))
        image = taken.photograph(CeilingRoom((lamp,)), resting, 0.0).image
        assert image[80, 100] == min(round(255.0 * level), 255)
        sizes.append(int((image > 200).sum()))
    assert sizes[0] == 0 < sizes[1] < sizes[2]


def test_only_lamps_in_the_image_are_projected() -> None:
    lamps = (CeilingLamp(OVERHEAD), CeilingLamp((1.0, 0.0, 2.5)), CeilingLamp((0.1, 0.1, 2.5)))
    photo = CeilingCamera(SMALL).photograph(CeilingRoom(lamps), resting, 0.0)
    assert [projection.lamp for projection in photo.lamp_projections] == [0, 2]


def test_a_lamp_at_the_edge_is_cut_and_not_changed() -> None:
    wide = PinholeCamera(260, 160, 636.4, 636.4, 129.5, 79.5)
    room = CeilingRoom((CeilingLamp((0.0, -0.39, 2.5)),))
    cut, whole = (camera(intrinsics=lens).light(room, resting, 0.0) for lens in (SMALL, wide))
    np.testing.assert_allclose(cut, whole[:, 30:-30], atol=1e-6)
    assert cut.max() > 0.5


def test_the_ceiling_moves_with_the_lamps() -> None:
    room = CeilingRoom((CeilingLamp(OVERHEAD, brightness=0.0),)).with_ambient_light(1000.0)
    taken = camera()
    here = taken.light(room, resting, 0.0)
    # One metre at 2.52 m is 252.54 px; eight panels of 0.6 m are the same ceiling again.
    again = taken.light(room, lambda _: camera_pose(SE2(4.8, -4.8, 0.0), UPWARD_MOUNT), 0.0)
    np.testing.assert_allclose(here, again, atol=1e-4)
    step = 20.0 * 2.52 / 636.4
    ahead = taken.light(room, lambda _: camera_pose(SE2(step, 0.0, 0.0), UPWARD_MOUNT), 0.0)
    np.testing.assert_allclose(ahead[20:], here[:-20], atol=1e-4)
