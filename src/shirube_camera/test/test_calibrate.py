"""The command from images to calibrations and report."""

import re

import cv2
import numpy as np
import pytest
from board_scene import BASELINE, CAMERA, RIGHT, Renderer, poses, seen_from_right

from shirube_camera.commands.calibrate import main
from shirube_camera.core import calibration
from shirube_ros.camera.files import load_camera_info

pytestmark = pytest.mark.newest_set_only

SQUARE = ('--square', '0.03')


@pytest.fixture(scope='module')
def double_images(tmp_path_factory):
    folder, left, right = tmp_path_factory.mktemp('double'), Renderer(CAMERA), Renderer(RIGHT)
    for k, pose in enumerate(poses(12, seed=2)):
        image = np.hstack([left(*pose), right(*seen_from_right(*pose))])
        cv2.imwrite(str(folder / f'{k:02d}.png'), image)
    return folder


def test_double_images_give_both_calibrations_and_a_report(double_images, tmp_path, capsys):
    assert main(['stereo', str(double_images), *SQUARE, '--out', str(tmp_path)]) == 0
    left, right = (load_camera_info(tmp_path / f'{side}.yaml') for side in ('left', 'right'))
    assert -right.p[3] / right.p[0] == pytest.approx(BASELINE, rel=2e-3)
    assert left.k[0] == pytest.approx(CAMERA.fx, rel=5e-3)
    assert 'camera_name: left' in (tmp_path / 'left.yaml').read_text()
    page = (tmp_path / 'report.html').read_text()
    assert '{{content}}' not in page
    assert page.count('"corners"') == 2
    assert 'baseline' in capsys.readouterr().out


def test_images_without_a_board_and_a_size_in_squares_are_refused_in_one_line(double_images, tmp_path, capsys):
    for columns in ('8', '3'):
        assert main(['lens', str(double_images), '--columns', columns, '--out', str(tmp_path / 'c.yaml')]) == 1
        line = r'calibrate: (only \d views can be used|the corners do not fit).*\n'
        assert re.fullmatch(line, capsys.readouterr().err)
    assert not any(tmp_path.iterdir())


def test_an_opencv_without_charuco_is_named(monkeypatch, capsys):
    monkeypatch.delattr(calibration.cv2, 'aruco', raising=False)
    assert main(['lens', '/', '--pattern', 'charuco']) == 1
    assert 'has no ChArUco detector; use a chessboard' in capsys.readouterr().err
