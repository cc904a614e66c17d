"""Targets are proposed from the committed drive in a corridor; their poses are those of its ground truth."""

from pathlib import Path

import numpy as np
import pytest

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import CameraMount
from stereo_landmark.commands.teach import main as teach
from stereo_landmark.commands.teach import make_parser
from stereo_landmark.core.landmark_localizer import LandmarkFix
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.drive_proposal import propose_place
from stereo_landmark.files.place_file import load_place
from stereo_landmark.page.pair_source import bag_pairs

BAG = Path(__file__).resolve().parents[3] / 'bags' / 'corridor_teach'
OPTIONS = ['--drive', str(BAG), '--accept', '--name', 'hall', '--camera-xyz', '0.1', '0.12', '1.25']


def true_positions():
    with BagReader(BAG) as bag:
        poses = [bag.decode(message).pose.position for message in bag.messages(['/ground_truth'])]
    return np.array([(pose.x, pose.y) for pose in poses])


def drive():
    options = make_parser().parse_args(OPTIONS)
    options.bag = options.drive
    return bag_pairs(options, CameraMount(tuple(options.camera_xyz), tuple(options.camera_rpy)))


def test_a_drive_proposes_shapes_that_give_the_true_poses():
    source = drive()
    proposal = propose_place('hall', len(source.labels), source.images, source.rig, LandmarkSettings())
    assert 3 <= len(proposal.recall) <= 10
    assert min(proposal.recall.values()) >= 0.7
    truth = true_positions()
    fixes = [each for each in proposal.results if isinstance(each, LandmarkFix)]
    assert len(fixes) == len(truth)
    errors = proposal.poses[:, :2] - (truth - truth[proposal.taught])
    assert np.linalg.norm(errors, axis=1).max() < 0.005
    stated = [each.displacement.position_sigma for each in fixes]
    assert np.mean(np.linalg.norm(errors, axis=1) <= 2.0 * np.array(stated)) >= 0.95


def test_a_drive_past_nothing_says_so():
    blank = StereoImages(*2 * (np.full((480, 752), 90, np.uint8),))
    with pytest.raises(StereoLandmarkError, match='only 0 shapes'):
        propose_place('hall', 3, lambda _: blank, drive().rig, LandmarkSettings())


def test_an_accepted_place_is_saved_and_replaced_only_on_purpose(tmp_path, capsys):
    places = ['--places', str(tmp_path)]
    assert teach([*OPTIONS, *places]) == 0
    assert '15 of 15 pairs give a pose' in capsys.readouterr().out
    assert load_place(tmp_path / 'hall.yaml').name == 'hall'
    assert teach([*OPTIONS, *places]) == 1
    assert 'exists; give --replace' in capsys.readouterr().err
