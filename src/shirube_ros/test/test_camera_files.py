"""Calibrations and images on disk."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from shirube_ros.camera.files import list_images, load_calibration, load_image
from shirube_ros.errors import CalibrationError, ImageFileError

# As camera_calibration writes it.
TEXT = """image_width: 640
image_height: 480
camera_name: belly
camera_matrix:
  rows: 3
  cols: 3
  data: [425.5, 0., 319.25, 0., 426.5, 240.75, 0., 0., 1.]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.25, 0.0625, 0.001, -0.002, 0.]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1., 0., 0., 0., 1., 0., 0., 0., 1.]
"""


def refusal(tmp_path: Path, **changes: object) -> str:
    fields = yaml.safe_load(TEXT) | changes
    path = tmp_path / 'belly.yaml'
    path.write_text(yaml.safe_dump({name: value for name, value in fields.items() if value != 'gone'}))
    with pytest.raises(CalibrationError) as caught:
        load_calibration(path)
    assert str(path) in str(caught.value)
    assert '\n' not in str(caught.value)
    return str(caught.value)


def test_the_file_of_camera_calibration_is_read(tmp_path: Path) -> None:
    (tmp_path / 'belly.yaml').write_text(TEXT)
    camera = load_calibration(tmp_path / 'belly.yaml')
    assert (camera.width, camera.height) == (640, 480)
    np.testing.assert_array_equal(camera.matrix, [[425.5, 0, 319.25], [0, 426.5, 240.75], [0, 0, 1]])
    assert camera.distortion == (-0.25, 0.0625, 0.001, -0.002, 0.0)


@pytest.mark.parametrize(
    ('field', 'value', 'part'),
    [
        ('image_width', 'gone', 'image_width is None'),
        ('image_height', 'tall', "image_height is 'tall'"),
        ('image_height', 0, 'must be positive'),
        ('camera_matrix', 'gone', 'camera_matrix with its data is missing'),
        ('camera_matrix', {'data': [1.0, 2.0]}, 'camera_matrix has 2 numbers'),
        ('camera_matrix', {'data': [0.0] * 9}, 'is not calibrated'),
        ('camera_matrix', {'data': [float('nan')] * 9}, 'not finite numbers'),
        ('camera_matrix', {'data': [10**400] * 9}, 'not finite numbers'),
        ('camera_matrix', {'data': [-1.0, 0, 1, 0, -1.0, 1, 0, 0, 1]}, 'must be positive'),
        ('distortion_coefficients', {'data': ['a']}, 'distortion_coefficients has values that are not finite'),
        ('distortion_coefficients', [0] * 5, 'distortion_coefficients with its data is missing'),
        ('distortion_model', 'fisheye', "unknown distortion model 'fisheye'"),
        ('distortion_coefficients', {'data': [0.1]}, "'plumb_bob' with 1 numbers instead of 0 or 4 or 5"),
    ],
)
def test_a_bad_field_is_named(tmp_path: Path, field: str, value: object, part: str) -> None:
    assert part in refusal(tmp_path, **{field: value})


def test_what_is_no_calibration_is_refused(tmp_path: Path) -> None:
    (tmp_path / 'belly.yaml').write_bytes(b'a: [1')
    with pytest.raises(CalibrationError, match='is no YAML'):
        load_calibration(tmp_path / 'belly.yaml')
    with pytest.raises(CalibrationError, match='No such file'):
        load_calibration(tmp_path / 'none.yaml')


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


@pytest.mark.parametrize('shape', [(20, 30), (20, 30, 3), (20, 30, 4)])
def test_pixels_come_back_as_they_were_written_without_transparency(tmp_path: Path, shape: tuple[int, ...]) -> None:
    original = picture(*shape)
    cv2.imwrite(str(tmp_path / 'image.png'), original)
    opaque = original[..., :3] if original.ndim == 3 else original
    np.testing.assert_array_equal(load_image(tmp_path / 'image.png'), opaque)


@pytest.mark.parametrize(
    ('content', 'part'),
    [
        (b'', 'is no image'),
        (b'x,y,diameter\n', 'is no image'),
        (None, 'No such file'),
        (cv2.imencode('.jpg', picture(8, 8))[1].tobytes()[:-20], 'is truncated'),
    ],
)
def test_what_is_no_image_is_refused(tmp_path: Path, content: bytes | None, part: str) -> None:
    if content is not None:
        (tmp_path / 'image.png').write_bytes(content)
    with pytest.raises(ImageFileError, match=rf'image\.png.*{part}'):
        load_image(tmp_path / 'image.png')


def test_a_missing_path_and_an_empty_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ImageFileError, match='does not exist'):
        list_images([tmp_path / 'none'])
    with pytest.raises(ImageFileError, match='has no images'):
        list_images([tmp_path])
