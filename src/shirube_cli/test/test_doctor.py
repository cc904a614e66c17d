"""Each fault of a snapshot gives its line, and a sound system gives none."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from shirube_bags.bag_reader import BagReader
from shirube_cli.doctor.findings import Severity, check_snapshot
from shirube_cli.doctor.parameter_names import unknown_names
from shirube_cli.doctor.snapshot import SeenImages, SeenInput, SeenNode, SeenPort, Snapshot
from shirube_cli.lamp_bands import BANDS_MIN, count_band_changes
from shirube_cli.main import main

ROOT = Path(__file__).resolve().parents[3]
STAMPS = tuple((np.arange(60) / 30.0 + 100.0).tolist())
ROLLING = {'use_sim_time': False, 'shutter': 'rolling', 'row_time': 18.9e-6, 'exposure_time': 6e-5}
LAMPS = SeenNode('/vlc_beacon', 1, ROLLING)
PIXELS = SeenInput('/vlc_beacon', '/image_raw', 'sensor_msgs/msg/Image', 1)
INFO = SeenInput('/vlc_beacon', '/camera_info', 'sensor_msgs/msg/CameraInfo', 1)
IMAGES = SeenImages('/image_raw', 'mono8', (1280, 1024), (1280, 1024), STAMPS, (0.02,) * 60, (9, 12, 0, 8, 7, 10))
SOUND = Snapshot(
    nodes=(LAMPS, SeenNode('/camera', 1, {'use_sim_time': False})),
    inputs=(PIXELS, INFO),
    images=(IMAGES,),
    ports=(SeenPort('/dev/ttyUSB0', exists=True, is_permitted=True),),
)


def with_images(**changes: object) -> Snapshot:
    return replace(SOUND, images=(replace(IMAGES, **changes),))  # type: ignore[arg-type]


def with_lamps(**changes: object) -> Snapshot:
    return replace(SOUND, nodes=(replace(LAMPS, parameters=ROLLING | changes),))


def test_a_sound_system_has_no_finding() -> None:
    assert check_snapshot(SOUND) == []


@pytest.mark.parametrize(
    ('snapshot', 'words'),
    [
        (Snapshot(ros_fault='no RMW'), 'no RMW'),
        (replace(SOUND, discovers_itself=False), 'do not discover'),
        (replace(SOUND, nodes=(replace(LAMPS, count=2),)), '2 nodes have this name'),
        (replace(SOUND, inputs=(replace(PIXELS, publishers=0), INFO)), 'nobody publishes the images'),
        (replace(SOUND, inputs=(PIXELS, replace(INFO, publishers=0))), 'nobody publishes the calibration'),
        (replace(SOUND, inputs=(replace(PIXELS, faults=('incompatible QoS',)), INFO)), 'incompatible QoS'),
        (with_images(encoding='mono12'), 'mono12'),
        (with_images(calibration=(640, 512)), 'their calibration is for 640 x 512'),
        (with_images(ages=(30.0,) * 60), '30.0 s old'),
        (with_images(ages=(-5.0,) * 60), 'in the future'),
        (with_images(stamps=(0.0,) * 60), 'stamps are 0'),
        (with_images(band_changes=(0,) * 6), 'no lamp has bands'),
        (with_lamps(shutter='global', exposure_time=5e-4), 'bands of a rolling shutter'),
        (with_lamps(exposure_time=5e-4), 'the light code is blurred'),
        (with_lamps(row_time=5e-5), 'the frame period 33.3 ms'),
        (with_lamps(use_sim_time=True), 'nobody publishes /clock'),
        (replace(SOUND, nodes=(*with_lamps(use_sim_time=True).nodes, SOUND.nodes[1]), has_clock=True), '/camera'),
        (replace(SOUND, statuses=(('/vlc_beacon', True, 'the lamps moved'),)), 'the lamps moved'),
        (replace(SOUND, ports=(SeenPort('/dev/x', exists=False, is_permitted=False),)), 'is not there'),
        (replace(SOUND, ports=(SeenPort('/dev/x', exists=True, is_permitted=False),)), 'may not be read'),
        (
            replace(SOUND, files={'a.yaml': {'/**': {'ros__parameters': {'shuter': 'global'}}}}),
            'there is no parameter shuter',
        ),
    ],
)
def test_each_fault_is_the_only_error(snapshot: Snapshot, words: str) -> None:
    found = check_snapshot(snapshot)
    assert [words in each.text for each in found if each.severity is Severity.ERROR] == [True], found
    assert found == sorted(found, key=lambda each: each.severity)
    assert all(each.remedy for each in found)


def test_a_global_shutter_needs_60_images_a_second() -> None:
    parameters = ROLLING | {'shutter': 'global', 'exposure_time': 5e-4}
    slow = replace(with_images(band_changes=(0,) * 6), nodes=(replace(LAMPS, parameters=parameters),))
    assert [each.text.split(';')[0] for each in check_snapshot(slow)] == ['30 images/s']
    fast = replace(IMAGES, band_changes=(0,) * 6, stamps=tuple(0.5 * stamp for stamp in STAMPS))
    assert check_snapshot(replace(slow, images=(fast,))) == []


def test_our_own_parameter_files_have_no_unknown_name() -> None:
    for path in sorted((ROOT / 'config').glob('*.yaml')):
        assert list(unknown_names(yaml.safe_load(path.read_text()))) == [], path
    spelled = {'robot': {'vlc_beacon': {'ros__parameters': {'lamps': {'diameter_mn': 4.0}, 'qos_overrides.x': 1}}}}
    assert list(unknown_names(spelled)) == [('lamps.diameter_mn', 'lamps.diameter_min')]
    assert list(unknown_names({'usb_cam': {'ros__parameters': {'fps': 30}}})) == []


def test_a_damaged_file_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'a.yaml'
    path.write_text('a: [')
    assert main(['doctor', str(path)]) == 1
    assert capsys.readouterr().err.count('\n') == 1


def test_only_lamps_under_a_rolling_shutter_have_bands() -> None:
    medians = [np.median(band_changes_in(ROOT / 'bags' / name)) for name in ('lamp_drive_rolling', 'lamp_drive')]
    assert medians[0] >= BANDS_MIN > medians[1]


def band_changes_in(path: Path) -> list[int]:
    """Return the changes of the lamps in some images of a bag."""
    with BagReader(path) as bag:
        images = [bag.decode(message) for message in bag.messages(['/image_raw/compressed'])][::60]
    pixels = [cv2.imdecode(image.data, cv2.IMREAD_GRAYSCALE) for image in images]
    return [count for each in pixels for count in count_band_changes(np.asarray(each, np.uint8))]
