"""`shirube try` never calls a method suitable that does not work, and says in one line what it cannot use."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from shirube_cli.main import main
from shirube_cli.suitability.scale import find_card

SIDE, SCALE = 400, 0.4  # of a photograph [px, mm/px]


def photograph(path: Path, dots: np.ndarray, *, turned: bool, seed: int) -> str:
    """Draw dots at pixels of the floor as a camera sees them that may be turned, in other light and moved."""
    rng, fine = np.random.default_rng(seed), np.full((4 * SIDE, 4 * SIDE, 3), 200, np.uint8)
    for x, y in 4 * dots:
        cv2.circle(fine, (int(x), int(y)), 14, (60, 60, 60), -1)
    image = cv2.resize(fine, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    if turned:
        turn = cv2.getRotationMatrix2D((0.5 * SIDE, 0.5 * SIDE), 80.0, 0.97)
        image = cv2.warpAffine(image, turn, (SIDE, SIDE), borderValue=(200, 200, 200))
    light = 0.8 if turned else 1.0
    cv2.imwrite(str(path), np.clip(light * image + rng.normal(0.0, 4.0, image.shape), 0, 255).astype(np.uint8))
    return str(path)


@pytest.fixture(scope='module')
def random_dots() -> np.ndarray:
    return np.random.default_rng(0).uniform(5, SIDE - 5, (160, 2))


def judge(tmp_path: Path, first: np.ndarray, second: np.ndarray) -> int:
    paths = [photograph(tmp_path / f'{n}.png', each, turned=bool(n), seed=n) for n, each in enumerate((first, second))]
    return main(['try', 'floor', *paths, '--mm-per-pixel', str(SCALE)])


def test_random_dots_suit_only_by_a_second_photograph_of_them(tmp_path, random_dots, capsys) -> None:
    assert judge(tmp_path, random_dots, random_dots) == 0
    assert 'This floor suits' in capsys.readouterr().out
    alone = [str(tmp_path / '0.png'), '--mm-per-pixel', str(SCALE)]
    assert main(['try', 'floor', alone[0], *alone]) == 1  # twice the same photograph
    assert 'photograph this area again' in capsys.readouterr().out


@pytest.mark.parametrize('repeats', [0, 10])
def test_a_blank_floor_and_one_that_repeats_do_not_suit(tmp_path, repeats, capsys) -> None:
    grid = np.stack(np.meshgrid(*[np.arange(20.0, SIDE, 40.0)] * 2), axis=-1).reshape(-1, 2)[: repeats * repeats]
    assert judge(tmp_path, grid, grid) == 1
    assert 'print_mat' in capsys.readouterr().out


def test_a_card_gives_the_scale(tmp_path, random_dots) -> None:
    image = cv2.imread(photograph(tmp_path / '0.png', random_dots, turned=False, seed=0))
    card = cv2.boxPoints(((200.0, 190.0), (85.6 / SCALE, 53.98 / SCALE), 20.0))
    cv2.fillPoly(image, [np.int32(card)], (160, 60, 20))
    assert math.isclose(find_card(image)[0], SCALE, rel_tol=0.03)


@pytest.mark.parametrize('arguments', [['floor'], ['landmarks', '--baseline', '0.1', '--fov', '60'], ['lamps']])
def test_a_file_that_is_no_picture_is_one_line(tmp_path, arguments, capsys) -> None:
    (tmp_path / 'junk.jpg').write_text('no picture')
    pair = 1 + (arguments[0] == 'landmarks')
    assert main(['try', arguments[0], *[str(tmp_path / 'junk.jpg')] * pair, *arguments[1:]]) == 2
    assert capsys.readouterr().err.count('\n') == 1


def test_a_blank_wall_and_a_dark_film_do_not_suit(tmp_path, capsys) -> None:
    paths = [photograph(tmp_path / f'{n}.png', np.empty((0, 2)), turned=False, seed=n) for n in range(2)]
    assert main(['try', 'landmarks', *paths, '--baseline', '0.1', '--fov', '60']) == 1
    assert main(['try', 'lamps', str(tmp_path)]) == 1
    assert 'no lamp is found' in capsys.readouterr().out
