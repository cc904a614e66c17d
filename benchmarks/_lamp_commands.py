"""The paper's run (3.3, figure 4) in closed loop at its scale: commands reach a moving robot and steer it.

Lamps of 6.5 cm at 2.5 m, 1280 x 1024 pixels, f 636.4 px. All lamps play their IDs while the robot finds itself; when it
drives off, A begins to send slow and turn, B turn and speed up, as rules of their zones.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from _lamp_films import BEACONS, KEY, RS_FSK_30, RS_FSK_60, UFSOOK, Channel, receiver_for

from scene_simulator.ceiling.camera import PAPER_OPTICS, UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling.lamp_drive import paper_room
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.imaging.exposure import camera_pose
from shirube_core.geometry import SE2
from vlc_beacon.core.authorization.command_authorizer import Accepted
from vlc_beacon.core.command_executor import CommandExecutor, DriveSettings, Velocity
from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.core.transmitter.message_encoder import EncoderContext, encode_messages

A, B = 4, 3
RIGHT = 'turn:-1.5708'
AUTHORIZATION = AuthorizationSettings(speed_limit=1.0)
WHEELS = 0.98  # distance driven over that commanded, which the odometry does not see
FEWER = 5  # every so manyth image is taken when both lamps have said everything: poses alone need no more
LATENCY = 0.02  # from the start of an image to the velocity that follows from it [s]


CHANNELS = RS_FSK_60, RS_FSK_30, UFSOOK


class Robot:
    """Wheels that do a little less than commanded, and the camera on top."""

    def __init__(self, pose: SE2) -> None:
        self.pose, self.velocity, self.stamp = pose, Velocity(), 0.0

    def pose_at(self, stamp: float) -> SE2:
        """Return ``T_map_base`` at a time [s]."""
        since = WHEELS * (stamp - self.stamp)
        return self.pose @ SE2.exp(self.velocity.forward * since, 0.0, self.velocity.turn_rate * since)

    def execute(self, velocity: Velocity | None, stamp: float) -> None:
        """Drive at a velocity from a time [s]."""
        self.pose, self.stamp, self.velocity = self.pose_at(stamp), stamp, velocity or Velocity()


class Instant(NamedTuple):
    """What is true at an image: pose, velocity, error of the pose [m] or NaN, commands accepted (lamp, operation)."""

    stamp: float
    pose: SE2
    velocity: Velocity
    error: float
    commands: Sequence[tuple[int, Operation]]


def drive(channel: Channel, speed: float, seconds: float, seed: int = 0) -> Iterator[Instant]:
    """Yield the images of a run that begins 2 m before A, where A comes into view; it ends after so many seconds."""
    eye, rng = CeilingCamera(PAPER_OPTICS, channel.shutter), np.random.default_rng(seed)
    phases = rng.uniform(0.0, 10.0, len(BEACONS)).tolist()
    silent, speaking = (lamps_that_say(each, channel, eye, phases) for each in ({}, programs(speed)))
    receiver = receiver_for(channel, AUTHORIZATION)
    executor = CommandExecutor(DriveSettings(cruise_speed=speed), AUTHORIZATION.speed_limit)
    robot, odometry = Robot(SE2(-0.2, 1.8 + rng.uniform(-0.05, 0.05), 0.0)), SE2(0.0, 0.0, 0.0)
    room, heard, last = silent, set[tuple[int | None, int]](), 0.0
    for index in range(round(seconds * channel.rate)):
        if len(heard) == 4 and index % FEWER:
            continue
        stamp = index / channel.rate
        odometry = odometry @ SE2.exp(
            robot.velocity.forward * (stamp - last), 0.0, robot.velocity.turn_rate * (stamp - last)
        )
        last = stamp
        image = eye.photograph(room, lambda time: camera_pose(robot.pose_at(time), UPWARD_MOUNT), stamp, rng).image
        receiver.add_odometry(stamp, odometry)
        output, pose = receiver.receive(stamp, image, PAPER_OPTICS), robot.pose_at(stamp)
        heard |= {(lamp.beacon, each.command.operation) for lamp in output.lamps for each in lamp.commands}
        error = math.nan
        if isinstance(output.result, BeaconFix):
            executor.update_pose(stamp, output.result.T_map_base)
            error = output.result.T_map_base.distance_to(pose)
        accepted = [d.outcome.command for d in output.decisions if isinstance(d.outcome, Accepted)]
        for command in accepted:
            executor.execute(Operation(command.operation), command.value)
        velocity = executor.velocity(stamp)
        commands = [(command.beacon, Operation(command.operation)) for command in accepted]
        yield Instant(stamp, pose, velocity or Velocity(), error, commands)
        robot.execute(velocity, stamp + LATENCY)
        room = speaking if robot.velocity.forward > 0.0 else room


def programs(speed: float) -> dict[int, list[str]]:
    """Return what A and B say: the paper's commands at A and B, with the ID before each to confirm it soon."""
    return {A: ['id', f'slow:{0.5 * speed}', 'id', RIGHT], B: ['id', RIGHT, 'id', f'speed_up:{speed}']}


def lamps_that_say(
    messages: dict[int, list[str]], channel: Channel, eye: CeilingCamera, phases: Sequence[float]
) -> CeilingRoom:
    """Return the paper's dark room; lamps without messages send their IDs."""
    waveforms = [
        channel.encode(encode_messages(messages.get(b.id, ['id']), EncoderContext(b.id, KEY, 1))) for b in BEACONS
    ]
    room = paper_room(waveforms, channel.shape, eye.brightness_for(0.9))
    lamps = zip(room.lamps, phases, strict=True)
    return replace(room, lamps=tuple(replace(lamp, phase=phase) for lamp, phase in lamps))
