from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from lamp_pictures import photograph
from scipy.special import expit

from vlc_beacon.commands import calibrate
from vlc_beacon.core.lamp_image.blooming import BloomingCalibration

ALPHA, BETA, GAMMA = 2.4, 2.5, 20.0
FOCAL, LAMP_RADIUS = 636.4, 0.0325
DEPTHS = (1.2, 1.6, 2.0, 2.5, 3.0)


@pytest.fixture
def images(tmp_path: Path) -> list[str]:
    """Images of eq. (4) corrected at known distances, with noise."""
    named, rng = [], np.random.default_rng(4)
    for depth in DEPTHS:
        v, u = np.mgrid[0:160, 0:200]
        distance = np.hypot(u - rng.uniform(95.0, 105.0), v - rng.uniform(75.0, 85.0))
        p = LAMP_RADIUS * FOCAL / depth
        outside = (220.0 - GAMMA) * (1.0 - expit(ALPHA * (distance - p - BETA))) + GAMMA
        path = tmp_path / f'{depth}.png'
        cv2.imwrite(str(path), photograph(np.where(distance <= p, 220.0, outside), 1.5, rng))
        named.append(f'{path}={depth}')
    return named


def run(*arguments: object, focal: float = FOCAL) -> int:
    given = (*arguments, '--focal-length', focal, '--lamp-radius', LAMP_RADIUS)
    return calibrate.main([str(argument) for argument in given])


def load(path: Path) -> BloomingCalibration:
    return BloomingCalibration(**yaml.safe_load(path.read_text())['blooming'])


def test_the_blooming_is_found_and_kept(images: list[str], tmp_path: Path) -> None:
    assert run(*images, '--out', tmp_path / 'out' / 'blooming.yaml') == 0
    blooming = load(tmp_path / 'out' / 'blooming.yaml')
    assert blooming.beta == pytest.approx(BETA, abs=0.05)
    assert abs(blooming.beta - BETA) < 4.0 * blooming.beta_sigma + 0.02


def test_a_wrong_focal_length_shows_in_sigma(images: list[str], tmp_path: Path) -> None:
    sigmas = []
    for focal in (FOCAL, 0.9 * FOCAL):
        assert run(*images, '--out', tmp_path / 'blooming.yaml', focal=focal) == 0
        sigmas.append(load(tmp_path / 'blooming.yaml').beta_sigma)
    assert sigmas[1] > 5.0 * sigmas[0]


def test_one_image_is_never_sure(images: list[str], tmp_path: Path) -> None:
    assert run(images[0], '--out', tmp_path / 'blooming.yaml') == 0
    assert load(tmp_path / 'blooming.yaml').beta_sigma == np.inf


def test_bad_input_ends_in_one_line(
    images: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        assert complaint in lines[0]
    assert not (tmp_path / 'blooming.yaml').exists()
    assert run(images[0], focal=-1.0) == 1
