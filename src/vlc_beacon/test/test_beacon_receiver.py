"""The complete receiver, from rendered images to IDs, pose and commands, and its poses by every method."""

import math
from dataclasses import dataclass, field

import lamp_room
import numpy as np
import pytest
from lamp_room import normalised_square
from lamp_scenes import BEACONS, CAMERA, MOUNT, PLACES, STRANGE_PLACE, id_packets, receptions, speaking_room
from numpy.typing import NDArray
from receptions import KEY, Memory

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling.lamp import Disc
from scene_simulator.ceiling.lamp_drive import PAPER_LAMPS, paper_room
from scene_simulator.imaging.exposure import Shutter, camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from vlc_beacon.core.authorization.command_authorizer import Accepted, CommandAuthorizer, RejectionReason
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracker import LampSample, LampTracker
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command, Operation, shorten
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix, NoFixReason
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, LampLocalizer, ReceiverOutput
from vlc_beacon.core.receiver.command_processor import CommandDecision, CommandProcessor
from vlc_beacon.core.receiver.light_receiver import LampObservation
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

RULE = Command(4, Operation.SLOW, 0.125, 7)
POSE = SE2(0.8, 1.0, 0.6)
STILL = np.zeros(3)


@dataclass
class Received:
    """What a drive brought."""

    errors: list[tuple[float, float, float]] = field(default_factory=list)
    reasons: set[NoFixReason] = field(default_factory=set)
    named: set[tuple[int, int]] = field(default_factory=set)
    decisions: list[CommandDecision] = field(default_factory=list)
    keyless: list[CommandDecision] = field(default_factory=list)
    last: ReceiverOutput | None = None


def authorizer(key=KEY, beacons=BEACONS):
    places = {beacon.id: beacon.xyz[:2] for beacon in beacons}
    return CommandAuthorizer(key, Memory(), places, AuthorizationSettings(zone_radius=2.0))


def lamp_at(centre, frame) -> int:
    """Return the index of the lamp that is truly at a place of the image."""
    points = frame.photo.pose.camera_points([*PLACES, STRANGE_PLACE])
    return int(np.argmin(np.hypot(*(CAMERA.pixels_from_points(points) - centre).T)))


@pytest.fixture(scope='module')
def striped() -> Received:
    """Five seconds of RS-FSK under a rolling shutter, the fourth lamp with a rule; UFSOOK has the lamp drive's bag."""
    packets = [[packet, packet] for packet in id_packets()]
    packets[3].append(shorten(KEY.sign(RULE)).to_bytes())
    waveforms = [rs_fsk_waveform(content, 30.0) for content in packets]
    drive = speaking_room(waveforms, Shutter(6e-5, 18.9e-6), 30.0)
    settings = ReceiverSettings(shutter='rolling', row_time=18.9e-6, exposure_time=6e-5)
    received, receiver = Received(), BeaconReceiver(BEACONS, MOUNT, authorizer(), settings)
    keyless = CommandProcessor(authorizer(None))
    for frame, output in receptions(receiver, drive, 5.0):
        received.last = output
        received.decisions += output.decisions
        received.keyless += keyless.process(frame.stamp, output.lamps)
        named = [lamp for lamp in output.lamps if lamp.beacon is not None]
        received.named |= {(lamp.beacon, lamp_at(lamp.sample.centre, frame) + 1) for lamp in named}
        if isinstance(output.result, NoBeaconFix):
            received.reasons.add(output.result.reason)
        else:
            pose, covariance = output.result.T_map_base, output.result.covariance[:2, :2]
            square = normalised_square(pose, covariance, frame.pose)
            turn = abs(pose.yaw_to(frame.pose))
            received.errors.append((pose.distance_to(frame.pose), turn, math.sqrt(2.0 * square)))
    return received


def test_each_lamp_gets_its_own_id_and_the_steady_one_none(striped: Received) -> None:
    assert striped.named == {(i, i) for i in range(1, 5)}
    assert striped.last is not None
    assert sum(lamp.beacon is not None for lamp in striped.last.lamps) == 4


def test_pose_error_matches_its_covariance(striped: Received) -> None:
    assert len(striped.errors) > 20
    assert (np.max(striped.errors, axis=0) < (0.02, 0.01, 3.0)).all()
    assert np.median([distance for distance, *_ in striped.errors]) < 0.008
    assert striped.reasons <= {NoFixReason.NO_LAMP, NoFixReason.TOO_FEW_LAMPS}


def test_a_rule_is_accepted_once_a_visit_and_rejected_once_without_a_key(striped: Received) -> None:
    accepted = [(v.outcome, v.sender) for v in striped.decisions if isinstance(v.outcome, Accepted)]
    assert accepted == [(Accepted(RULE), 4)]
    refused = [v.outcome for v in striped.decisions if not isinstance(v.outcome, Accepted)]
    assert all(outcome.reason is RejectionReason.WRONG_BEACON for outcome in refused)
    assert [decision.outcome.reason for decision in striped.keyless] == [RejectionReason.NO_KEY]


def test_a_camera_that_looks_down_is_rejected() -> None:
    with pytest.raises(VlcBeaconError, match='does not look up'):
        BeaconReceiver(BEACONS, CameraMount(), authorizer(None))


def seen(pose, count=4, *, dark=(), bloom=0.0) -> list[LampObservation]:
    """Return lamps as an image shows them, 2.5 m above the camera."""
    radius = 0.0325 * lamp_room.CAMERA.fx / (2.8 - lamp_room.MOUNT.xyz[2]) + bloom
    sigmas = [np.full(2, math.inf if i in dark else 0.1) for i in range(count)]
    pixels = lamp_room.pixels_of(lamp_room.BEACONS[:count], pose)
    samples = [LampSample(i, pixels[i], sigmas[i], radius, np.ones(2), None, i) for i in range(count)]
    return [LampObservation(sample, i + 1, None, ()) for i, sample in enumerate(samples)]


def localizer(**changed):
    """Return a function from lamps, and perhaps odometry and velocity, to a pose."""
    made = LampLocalizer(lamp_room.BEACONS, lamp_room.MOUNT, ReceiverSettings(**changed))
    return lambda lamps, odometry=None, velocity=STILL: made.locate(
        lamps, lamp_room.CAMERA, odometry, velocity, (0.0, 0.0)
    )


@pytest.mark.parametrize(('method', 'within'), [('centroid', 1e-6), ('radius_interval', 0.01)])
def test_methods_that_are_right_find_the_pose(method: str, within: float) -> None:
    result = localizer(method=method)(seen(POSE))
    assert isinstance(result, BeaconFix)
    assert result.T_map_base.distance_to(POSE) < within
    assert abs(result.T_map_base.yaw_to(POSE)) < 1e-6
    assert abs(result.height) < 0.01
    assert (np.diag(result.covariance) > 0.0).all()


def test_the_printed_equations_find_another_place() -> None:
    result = localizer(method='radius_interval_printed')(seen(POSE))
    assert isinstance(result, BeaconFix)
    assert result.T_map_base.distance_to(POSE) > 0.1


def test_blooming_is_taken_off_the_radius() -> None:
    lamps = seen(POSE, bloom=2.0)
    plain, off = (localizer(method='radius_interval', blooming=px)(lamps) for px in (2.0, 0.0))
    assert isinstance(plain, BeaconFix)
    assert abs(plain.height) < 0.01
    assert isinstance(off, NoBeaconFix) or abs(off.height) > 0.1


def test_dark_lamps_do_not_count() -> None:
    assert localizer()(seen(POSE, dark=(0, 1, 2, 3))).reason is NoFixReason.NO_LAMP


def test_one_lamp_carries_the_pose_on_with_odometry_only() -> None:
    locate, start, later = localizer(), SE2(5.0, 5.0, 0.0), SE2(5.2, 5.0, 0.05)
    moved = POSE @ start.inverse() @ later
    assert isinstance(locate(seen(POSE), start), BeaconFix)
    assert locate(seen(moved, 1), later).T_map_base.distance_to(moved) < 0.005
    assert locate(seen(moved, 1)).reason is NoFixReason.TOO_FEW_LAMPS


def test_rows_of_a_moving_robot_are_seen_from_where_it_was() -> None:
    lamps = seen(POSE)
    for _ in range(3):  # a lamp's row tells when it is seen
        rows = [lamp.sample.centre[1] for lamp in lamps]
        poses = [POSE @ SE2(30e-6 * row, 0.0, 0.8 * 30e-6 * row) for row in rows]
        lamps = [seen(pose)[i] for i, pose in enumerate(poses)]
    result = localizer(shutter='rolling', row_time=30e-6)(lamps, None, np.array([1.0, 0.0, 0.8]))
    assert result.T_map_base.distance_to(POSE) < 5e-4
    assert math.isclose(result.T_map_base.yaw, POSE.yaw, abs_tol=5e-4)


@pytest.mark.parametrize(('count', 'later', 'jump'), [(1, 10.1, SE2(0.6, 0.0, 0.2)), (4, 12.0, SE2(50.0, -40.0, 2.0))])
def test_an_odometry_jump_between_two_images_is_no_motion(count, later, jump, monkeypatch) -> None:
    """The image does not turn with it, one lamp does not carry the pose over it, and several authorize at once."""
    permit, rotations = authorizer(beacons=lamp_room.BEACONS), []
    receiver = BeaconReceiver(lamp_room.BEACONS, lamp_room.MOUNT, permit)
    images = iter([seen(POSE), seen(POSE, count)])
    monkeypatch.setattr(receiver._light, 'receive', lambda *given: rotations.append(given[2]) or next(images))
    for stamp, odometry in ((10.0, SE2(0.0, 0.0, 0.0)), (later, jump)):
        receiver.add_odometry(stamp, odometry)
        result = receiver.receive(stamp, np.zeros((64, 64), np.uint8), lamp_room.CAMERA).result
    assert rotations == [0.0, 0.0]
    if count == 1:
        assert result.reason is NoFixReason.TOO_FEW_LAMPS
    else:
        assert result.T_map_base.distance_to(POSE) < 1e-6
        assert permit.authorize(KEY.sign(RULE), 4, later) == Accepted(RULE)


def heights_at(level: float) -> NDArray[np.float64]:
    """Return heights of the robot, truly 0, at an exposure by radii of the threshold and of eq. (4), shape (n, 2)."""
    camera = PinholeCamera(720, 720, 636.4, 636.4, 359.5, 359.5)
    eye, rng, heights = CeilingCamera(camera), np.random.default_rng(1), []
    beacons = [Beacon(i + 1, place, Disc().radius) for i, place in enumerate(PAPER_LAMPS)]
    settings = ReceiverSettings(method='radius_interval', blooming=eye.lens.blooming.spread)
    made = LampLocalizer(beacons, UPWARD_MOUNT, settings)
    room = paper_room([ufsook_waveform([packet]) for packet in id_packets()], Disc(), eye.brightness_for(level))
    tracker, detector = LampTracker(), LampDetector()
    for stamp in (np.arange(46) / 60.0).tolist():
        photo = eye.photograph(room, lambda _: camera_pose(POSE, UPWARD_MOUNT), stamp, rng)
        true = np.array([projection.centre for projection in photo.lamp_projections])
        lamps = [
            LampObservation(sample, 1 + int(np.hypot(*(true - sample.centre).T).argmin()), None, ())
            for sample in tracker.update(stamp, photo.image, detector.detect(photo.image))
            if sample.half_brightness.min() > 0.9
        ]
        if stamp > 0.5 and len(lamps) >= 2:
            given = lamps, camera, None, STILL, (0.0, 0.0)
            fixes = made.locate(*given), made.locate(*given, photo.image)
            heights.append([fix.height if isinstance(fix, BeaconFix) else math.nan for fix in fixes])
    return np.array(heights)


@pytest.mark.parametrize(('level', 'worst'), [(0.9, 0.01), (1.6, 0.08)])
def test_the_profile_of_eq_4_gives_the_depth_of_eq_3_at_any_exposure(level: float, worst: float) -> None:
    """Overexposure and the glow move the threshold outwards, against which `blooming` alone is of no use."""
    by_threshold, by_profile = np.abs(heights_at(level)).T
    assert len(by_profile) > 5
    assert by_profile.max() < worst
    # NaN where the intervals of the thresholded radii are disjoint.
    assert not (by_threshold < 2.0 * by_profile.max()).any()
