"""Localization of a tilted and raised robot from image files and from a bag."""

import csv

import cv2
import pytest
from taught_wall import TAUGHT, seen, taught_place, write_files

from stereo_landmark.commands.locate import main
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.files.place_file import load_places, save_place
from stereo_landmark.node import validate_places
from stereo_landmark.page.pair_source import taught_pair

TILT = (0.04, -0.03)
LEANING = (0.15, -0.1, 0.05, 0.06, *TILT)
STAMP = 1_700_000_000_000_000_000


def pose_of(folder):
    (row,) = csv.DictReader((folder / 'poses.csv').open())
    return [float(row[name]) for name in ('x', 'y', 'z', 'yaw')]


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    written = write_files(tmp_path_factory.mktemp('wall'))
    for side, image in zip(('left', 'right'), seen(LEANING)):
        cv2.imwrite(str(written.images[side]), image)
    return written


def test_the_option_sets_the_tilt_of_image_files(files, tmp_path):
    assert main(files.options('--tilt', *map(str, TILT), '--out', str(tmp_path))) == 0
    assert pose_of(tmp_path) == pytest.approx(LEANING[:4], abs=0.01)


def test_the_tilt_at_teaching_is_used_in_validation_and_further_teaching(tmp_path, monkeypatch):
    path = save_place(tmp_path, taught_place(), StereoImages(*seen(TAUGHT), TILT))
    assert taught_pair(path).images(0).tilt == TILT
    asked = []
    locate = LandmarkLocalizer.locate

    def remembered(self, left, right, tilt=(0.0, 0.0), likely_places=()):
        asked.append(tilt)
        return locate(self, left, right, tilt, likely_places)

    monkeypatch.setattr(LandmarkLocalizer, 'locate', remembered)
    validate_places(tmp_path, load_places(tmp_path), LandmarkSettings())
    assert asked == [TILT]
