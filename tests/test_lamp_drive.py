"""The recorded drive under lamps decodes as documented: IDs, commands and poses; a survey finds its lamps."""

import json
import math
import shutil
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from node_testing import first_seconds, poses_in, replay_live

from shirube_bags.accuracy import compare_trajectories
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.trajectory_files import load_bag_trajectory, load_tum
from shirube_core.geometry import SE2
from shirube_ros.offline.recording import choose_topics
from vlc_beacon.commands import locate, survey
from vlc_beacon.commands.locate import LocatedImage, locate_bag
from vlc_beacon.core.authorization.command_authorizer import Accepted, Rejected, RejectionReason
from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, ReceiverOutput
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.files.authorization_files import CounterFile
from vlc_beacon.files.beacons_file import load_beacons
from vlc_beacon.node import VlcBeaconNode
from vlc_beacon.node_settings import NodeSettings, authorizer_from_settings, beacons_from_settings

pytestmark = pytest.mark.newest_set_only

BAG = Path(__file__).parents[1] / 'bags' / 'lamp_drive'
KEPT = [i for i in range(1500) if not 760 <= i < 1420 or i % 4 == 0]
"""Images of the first 25 s: all while the lamps are heard, fewer on the way to the second, for poses alone."""
IMAGES = len(KEPT)
LAMP_A, LAMP_B = 4, 3


@dataclass
class Run:
    """What the receiver made of the bag; accepted commands have a lamp, an operation and its value."""

    images: list[LocatedImage]
    truth: dict[int, SE2]
    obeyed: list[tuple[int, Operation, float]] = field(default_factory=list)
    refused: set[RejectionReason] = field(default_factory=set)


class FewerImages(BagReader):
    """A bag of which only some images, and their truth, are read."""

    def messages(self, topics: Iterable[str] = ()) -> Iterator[BagMessage]:
        seen, kept = Counter[str](), set(KEPT)
        for message in super().messages(topics):
            if message.topic in ('/image_raw/compressed', '/ground_truth'):
                seen[message.topic] += 1
                if seen[message.topic] - 1 not in kept:
                    continue
            yield message


def files(folder: Path) -> dict[str, str]:
    """Return the parameters that name files, with the key that was made for the bag."""
    shutil.copy(BAG / 'demo_key', folder / 'key')
    (folder / 'key').chmod(0o600)
    CounterFile(folder / 'counters.json').reset(0)
    return {
        'beacons_file': str(BAG / 'beacons.yaml'),
        'key_file': str(folder / 'key'),
        'counter_file': str(folder / 'counters.json'),
    }


@pytest.fixture(scope='module')
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The bag through the receiver."""
    node = NodeSettings(**files(tmp_path_factory.mktemp('lamp_drive')))
    beacons = beacons_from_settings(node)
    authorizer = authorizer_from_settings(node, AuthorizationSettings(), beacons)
    with FewerImages(BAG) as bag:
        localization = locate_bag(
            bag, choose_topics(bag, None, None, None, None), lambda: BeaconReceiver(beacons, node.mount, authorizer)
        )
        found = Run(list(islice(localization, IMAGES)), poses_in(bag, '/ground_truth'))
    for image in found.images:
        assert isinstance(image.result, ReceiverOutput)
        for decision in image.result.decisions:
            if isinstance(decision.outcome, Accepted):
                command = decision.outcome.command
                found.obeyed.append((command.beacon, Operation(command.operation), command.value))
            elif isinstance(decision.outcome, Rejected):
                found.refused.add(decision.outcome.reason)
    return found


def test_the_commands_are_obeyed_at_their_lamps_and_once(run: Run) -> None:
    assert run.obeyed == [
        (LAMP_A, Operation.SLOW, 0.125),
        (LAMP_A, Operation.TURN, pytest.approx(-math.pi / 2.0, abs=1e-4)),
        (LAMP_B, Operation.TURN, pytest.approx(-math.pi / 2.0, abs=1e-4)),
        (LAMP_B, Operation.SPEED_UP, 0.25),
    ]
    assert run.refused == {RejectionReason.WRONG_LOCATION}


def test_only_the_four_lamps_are_named_and_soon(run: Run) -> None:
    named = [
        {lamp.beacon for lamp in image.result.lamps if lamp.beacon is not None}
        for image in run.images
        if isinstance(image.result, ReceiverOutput)
    ]
    assert set().union(*named) == set().union(*named[:150]) == {1, 2, 3, 4}


def test_poses_are_as_good_as_they_say(run: Run) -> None:
    fixes = [(image.fix, run.truth[image.stamp_ns]) for image in run.images if image.fix is not None]
    assert len(fixes) > 0.85 * IMAGES
    found = [(fix.T_map_base, true) for fix, true in fixes]
    errors = np.array([(pose.x - true.x, pose.y - true.y, true.yaw_to(pose)) for pose, true in found])
    places = np.hypot(errors[:, 0], errors[:, 1])
    assert np.median(places) < 0.004
    assert places.max() < 0.025
    assert np.abs(errors[:, 2]).max() < math.radians(1.0)
    covariances = np.array([fix.covariance[:2, :2] for fix, _ in fixes])
    squares = np.einsum('ni,nij,nj->n', errors[:, :2], np.linalg.inv(covariances), errors[:, :2])
    assert np.sqrt(np.mean(squares) / 2.0) < 1.5


def test_a_survey_finds_the_lamps_of_the_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / 'beacons.yaml'
    arguments = [str(first_seconds(tmp_path / 'bag', 12.0, BAG)), '--lamp-radius', '0.0325', '--out', str(out)]
    assert survey.main([*arguments, '--camera-xyz', '0', '0', '0']) == 0
    found, true = load_beacons(out), load_beacons(BAG / 'beacons.yaml')
    assert [beacon.id for beacon in found] == [beacon.id for beacon in true] == [1, 2, 3, 4]
    errors = np.array([beacon.xyz for beacon in found]) - [beacon.xyz for beacon in true]
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith('beacon ')]
    sigmas = np.array([[float(part.split()[0]) for part in line.split('+-')[1:]] for line in lines])
    assert np.abs(errors).max() < 0.005
    assert (np.abs(errors) < 3.0 * sigmas + 0.0001).all()


def test_a_rolling_shutter_gives_the_same_path(tmp_path: Path) -> None:
    bag = BAG.with_name('lamp_drive_rolling')
    beginning = first_seconds(tmp_path / 'bag', 9.0, bag)
    arguments = ['--beacons', str(bag / 'beacons.yaml'), '--bag', str(beginning), '--out', str(tmp_path)]
    camera = ['--shutter', 'rolling', '--exposure-time', '60e-6', '--camera-xyz', '0', '0', '0']
    assert locate.main([*arguments, *camera]) == 0
    with BagReader(bag) as reader:
        truth = load_bag_trajectory(reader, '/ground_truth')
    errors = compare_trajectories(load_tum(tmp_path / 'poses.tum'), truth, longest_gap=0.1)
    assert len(errors.position) > 205
    assert np.median(errors.position) < 0.004
    assert errors.position.max() < 0.02
    assert np.abs(errors.heading).max() < math.radians(0.5)


@pytest.mark.timeout(300)
def test_the_live_node_is_located_and_obeys_too(tmp_path: Path) -> None:
    """All messages while the lamps are read; then a few, for the pose, until the robot is under lamp A."""
    bag = first_seconds(tmp_path / 'bag', 12.6, BAG, lambda time: time < 6.5 or time % 0.25 < 0.03)
    errors, truths, commands = replay_live(VlcBeaconNode, bag, camera_xyz=[0.0, 0.0, 0.0], **files(tmp_path))
    assert len(errors) > 0.5 * truths
    assert np.median(errors) < 0.004
    assert errors.max() < 0.025
    (command,) = (json.loads(command) for command in commands)
    assert (command['beacon'], command['op'], command['value']) == (LAMP_A, 'slow', 0.125)


@pytest.mark.timeout(300)
def test_the_live_node_is_located_with_a_rolling_shutter(tmp_path: Path) -> None:
    source = BAG.with_name('lamp_drive_rolling')
    bag = first_seconds(tmp_path / 'bag', 4.5, source)
    camera = {'shutter': 'rolling', 'exposure_time': 60e-6, 'camera_xyz': [0.0, 0.0, 0.0]}
    errors, _, commands = replay_live(VlcBeaconNode, bag, beacons_file=str(source / 'beacons.yaml'), **camera)
    assert len(errors) > 30
    assert np.median(errors) < 0.004
    assert errors.max() < 0.02
    assert commands == []
