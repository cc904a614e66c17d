from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from lamp_pictures import BETA, FOCAL, LAMP_RADIUS, blooming_image

from vlc_beacon.commands import calibrate
from vlc_beacon.core.lamp_image.blooming import BloomingCalibration


@pytest.fixture
def images(tmp_path: Path) -> list[str]:
    """Images of eq. (4) corrected at known distances, with noise."""
    named, rng = [], np.random.default_rng(4)
    for depth in (1.2, 1.6, 2.0, 2.5, 3.0):
        image, _ = blooming_image((160, 200), rng.uniform((95.0, 75.0), (105.0, 85.0)), depth, 20.0, rng)
        path = tmp_path / f'{depth}.png'
        cv2.imwrite(str(path), image)
        named.append(f'{path}={depth}')
    return named


def run(*arguments: object, focal: float = FOCAL) -> int:
    given = (*arguments, '--focal-length', focal, '--lamp-radius', LAMP_RADIUS)
    return calibrate.main([str(argument) for argument in given])


def load(path: Path) -> BloomingCalibration:
    return BloomingCalibration(**yaml.safe_load(path.read_text())['blooming'])


def test_the_blooming_is_found_and_its_sigma_shows_a_wrong_focal_length_and_a_lone_image(images, tmp_path):
    out = tmp_path / 'out' / 'blooming.yaml'
    assert run(*images, '--out', out) == 0
    blooming = load(out)
    assert blooming.beta == pytest.approx(BETA, abs=0.05)
    assert abs(blooming.beta - BETA) < 4.0 * blooming.beta_sigma + 0.02
    assert run(*images, '--out', out, focal=0.9 * FOCAL) == 0
    assert load(out).beta_sigma > 5.0 * blooming.beta_sigma
    assert run(images[0], '--out', out) == 0
    assert load(out).beta_sigma == np.inf


def test_bad_input_ends_in_one_line(images: list[str], tmp_path: Path, capsys) -> None:
    cv2.imwrite(str(tmp_path / 'dark.png'), np.zeros((100, 100), np.uint8))
    (tmp_path / 'no.png').write_text('no image')
    bad = {
        'IMAGE=METRES': images[0].rpartition('=')[0],
        'no lamp found': f'{tmp_path / "dark.png"}=2',
        'is no image': f'{tmp_path / "no.png"}=2',
        'cannot be read': f'{tmp_path / "none.png"}=2',
    }
    for complaint, image in bad.items():
        assert run(image, '--out', tmp_path / 'blooming.yaml') == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert complaint in line
    assert not (tmp_path / 'blooming.yaml').exists()
    assert run(images[0], focal=-1.0) == 1
