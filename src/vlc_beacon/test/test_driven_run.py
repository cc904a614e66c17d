"""The paper's run (3.3) in closed loop: commands move the robot, and images follow from its pose."""

import math

import numpy as np
import pytest
from receptions import KEY, Memory

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling.lamp import Disc
from scene_simulator.ceiling.paper_run import PAPER_LAMPS, paper_room
from scene_simulator.imaging.exposure import Shutter, camera_pose
from shirube_core.geometry import SE2, PinholeCamera
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.decision import Accepted
from vlc_beacon.core.command_executor import CommandExecutor, DriveSettings, Velocity
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.packet.command_packet import Command, Operation
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings

pytestmark = pytest.mark.newest_set_only

CAMERA = PinholeCamera(320, 320, 150.0, 150.0, 159.5, 159.5)
RADIUS = 0.12
LIGHT = ReceiverSettings(shutter='rolling', row_time=18.9e-6, exposure_time=6e-5)
CRUISE, SLOW = 0.4, 0.2
HEARD = 8.6
"""All lamps have said everything by then [s]."""
STAMPS = np.concatenate([np.arange(0.0, HEARD, 1.0 / 30.0), np.arange(HEARD, 26.0, 0.16)])
"""Poses alone need fewer images than the light's code [s]."""
SAID = {
    3: ((Operation.TURN, -0.5 * math.pi), (Operation.SPEED_UP, CRUISE)),
    4: ((Operation.SLOW, SLOW), (Operation.TURN, -0.5 * math.pi)),
}
"""What the paper's B and A say."""
AUTHORIZATION = AuthorizationSettings()


class Robot:
    """Wheels that do a little less than they are told, and the camera on top."""

    def __init__(self, pose: SE2) -> None:
        self.pose, self.velocity, self.stamp = pose, Velocity(), 0.0

    def pose_at(self, stamp: float) -> SE2:
        since = 0.98 * (stamp - self.stamp)
        return self.pose @ SE2.exp(self.velocity.forward * since, 0.0, self.velocity.turn_rate * since)

    def execute(self, velocity: Velocity | None, stamp: float) -> None:
        self.pose, self.stamp, self.velocity = self.pose_at(stamp), stamp, velocity or Velocity()


def packets_of(beacon: int) -> list[bytes]:
    rules = [KEY.sign(Command(beacon, *said, 1)).to_bytes() for said in SAID.get(beacon, ())]
    return [IdPacket(beacon).to_bytes(), *rules, IdPacket(beacon).to_bytes()]


Log = list[tuple[SE2, Velocity]]


@pytest.fixture(scope='module')
def run() -> Log:
    """True poses and velocities; the robot begins 0.7 m before A and stands until A was heard."""
    beacons = [Beacon(i + 1, place, RADIUS) for i, place in enumerate(PAPER_LAMPS)]
    authorizer = CommandAuthorizer(KEY, Memory(), {b.id: b.xyz[:2] for b in beacons}, AUTHORIZATION)
    receiver = BeaconReceiver(beacons, UPWARD_MOUNT, authorizer, LIGHT)
    executor = CommandExecutor(DriveSettings(cruise_speed=CRUISE), AUTHORIZATION.speed_limit)
    eye = CeilingCamera(CAMERA, Shutter(LIGHT.exposure_time, LIGHT.row_time))
    waveforms = [rs_fsk_waveform(packets_of(beacon.id), 30.0) for beacon in beacons]
    room = paper_room(waveforms, Disc(RADIUS), eye.brightness_for(0.9))
    robot, rng, log = Robot(SE2(1.1, 1.8, 0.0)), np.random.default_rng(1), []
    for stamp in STAMPS.tolist():
        photo = eye.photograph(room, lambda time: camera_pose(robot.pose_at(time), UPWARD_MOUNT), stamp, rng)
        output = receiver.receive(stamp, photo.image, CAMERA)
        if isinstance(output.result, BeaconFix) and stamp >= HEARD:
            executor.update_pose(stamp, output.result.T_map_base)
        accepted = [
            decision.outcome for decision in output.decisions if isinstance(decision.outcome, Accepted)
        ]
        for outcome in accepted:
            executor.execute(Operation(outcome.command.operation), outcome.command.value)
        velocity = executor.velocity(stamp)
        log.append((robot.pose, velocity or Velocity()))
        # An image takes a while to be read.
        robot.execute(velocity, stamp + 0.02)
    return log


def test_the_robot_turns_where_the_lamps_say_and_drives_as_fast_as_they_say(run: Log) -> None:
    for lamp, yaw in ((4, 0.0), (3, -0.5 * math.pi)):
        half_way_round = SE2(0.0, 0.0, yaw - 0.25 * math.pi)
        pose = min((pose for pose, _ in run), key=lambda pose: abs(pose.yaw_to(half_way_round)))
        assert math.dist((pose.x, pose.y), PAPER_LAMPS[lamp - 1][:2]) < AUTHORIZATION.zone_radius + 0.05
    ahead = [velocity.forward for pose, velocity in run if 0.5 < pose.y < 1.3]
    assert np.median(ahead) == pytest.approx(SLOW)
    assert max(ahead) <= SLOW + 1e-9
    assert max(velocity.forward for _, velocity in run) <= AUTHORIZATION.speed_limit
    # It leaves backwards.
    end, velocity = run[-1]
    assert abs(end.yaw_to(SE2(0.0, 0.0, math.pi))) < 0.02
    assert velocity.forward == pytest.approx(CRUISE)
    assert end.y == pytest.approx(0.0, abs=AUTHORIZATION.zone_radius + 0.05)
    assert end.x < 1.5
