from pathlib import Path

import cv2
import numpy as np
import pytest

from shirube_ros.camera.files import list_images, load_image
from shirube_ros.errors import ImageFileError


def picture(*shape: int, dtype: type = np.uint8) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 255, shape).astype(dtype)


def test_a_folder_gives_its_images_by_name_and_files_stay_in_their_order(tmp_path: Path) -> None:
    for name in ('b.png', 'a.PNG', 'c.jpg'):
        cv2.imwrite(str(tmp_path / name.lower()), picture(8, 8))
        (tmp_path / name.lower()).rename(tmp_path / name)
    (tmp_path / 'notes.txt').write_text('no image')
    assert [path.name for path in list_images([tmp_path])] == ['a.PNG', 'b.png', 'c.jpg']
    files = [tmp_path / 'c.jpg', tmp_path / 'b.png']
    assert list_images(files) == files


@pytest.mark.parametrize('shape', [(20, 30), (20, 30, 3)])
def test_pixels_come_back_as_they_were_written(tmp_path: Path, shape: tuple[int, ...]) -> None:
    original = picture(*shape)
    cv2.imwrite(str(tmp_path / 'image.png'), original)
    np.testing.assert_array_equal(load_image(tmp_path / 'image.png'), original)


def test_transparency_is_left_out(tmp_path: Path) -> None:
    original = picture(20, 30, 4)
    cv2.imwrite(str(tmp_path / 'image.png'), original)
    np.testing.assert_array_equal(load_image(tmp_path / 'image.png'), original[:, :, :3])


@pytest.mark.parametrize(
    ('content', 'part'), [(b'', 'is no image'), (b'x,y,diameter\n', 'is no image'), (None, 'No such file')]
)
def test_what_is_no_image_is_refused(tmp_path: Path, content: bytes | None, part: str) -> None:
    if content is not None:
        (tmp_path / 'image.png').write_bytes(content)
    with pytest.raises(ImageFileError, match=rf'image\.png.*{part}'):
        load_image(tmp_path / 'image.png')


def test_sixteen_bits_a_channel_are_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / 'deep.png'), picture(8, 8, dtype=np.uint16))
    with pytest.raises(ImageFileError, match='16 bits'):
        load_image(tmp_path / 'deep.png')


def test_a_missing_path_and_an_empty_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ImageFileError, match='does not exist'):
        list_images([tmp_path / 'none'])
    with pytest.raises(ImageFileError, match='has no images'):
        list_images([tmp_path])
