"""Records the paper's run under its lamps as a bag with ground truth.

What the lamps send comes from waveform files, such as ``vlc_beacon encode --csv`` writes.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from scene_simulator import messages
from scene_simulator.ceiling.camera import CeilingCamera
from scene_simulator.ceiling.lamp import Disc, LedGrid
from scene_simulator.ceiling.lamp_drive import PAPER_LAMPS, LampDrive, LampFrame, paper_run
from scene_simulator.commands.recording import Entry, bag_parser, run_recording, stamp_at, write_drive
from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import CameraClock, Shutter
from shirube_core.files import write_text
from shirube_core.geometry import PinholeCamera
from shirube_core.waveform import LightWaveformError, Waveform, waveform_from_csv

GLOBAL = CeilingCamera(PinholeCamera(640, 512, 318.2, 318.2, 319.5, 255.5))
"""The paper's camera at half its resolution: large enough to read the lamps, and a third of the bag's size."""

ROLLING = CeilingCamera(shutter=Shutter(exposure=60e-6, row_time=18.9e-6))
"""A telephone's shutter behind the paper's optics at full resolution: a lamp must cover 16 rows."""

REST = 5.0  # two IDs and two commands of lamp A have then been played when the robot begins to turn there [s]

CLOCK_RATIO, JITTER = 1.00005, 5e-5
"""Clock rate of the camera relative to the lamps (50 ppm); the jitter of the stamps [s]."""

CAMERA_FRAME = 'ceiling_camera_optical_frame'
JPEG_QUALITY = 60


def record_lamp_bag(arguments: Sequence[str] | None = None) -> int:
    """``record_lamp_bag``: render the paper's run under its lamps as a bag; the same seed gives the same bag.

    What the lamps send comes from waveform files, such as ``vlc_beacon encode --csv`` writes.
    """
    parser = bag_parser('record_lamp_bag', record_lamp_bag.__doc__, 39.0, 0, 'the room, noise and errors')
    about = (
        'ID and waveform of each lamp: at (0, 0), (0, 1.8), (1.8, 0) and (1.8, 1.8) m; the last one is A, before it B'
    )
    parser.add_argument('lamp', nargs='+', metavar='ID=FILE.csv', help=about)
    about = 'camera shutter; rolling: disc lamps, 30 Hz, full resolution (default: %(default)s)'
    parser.add_argument('--shutter', default='global', choices=('global', 'rolling'), help=about)
    options = parser.parse_args(arguments)

    def record() -> tuple[Iterator[int], int, str]:
        drive, ids = make_drive(options)
        line = f"{options.bag}: {options.seconds} s of the paper's run"
        return _record_with_beacons(drive, ids, options), drive.frame_count(options.seconds), line

    return run_recording('record_lamp_bag', record, 'image')


def _record_with_beacons(drive: LampDrive, ids: list[int], options: argparse.Namespace) -> Iterator[int]:
    yield from record_lamp_drive(drive, options.bag, options.seconds)
    write_beacons(list(zip(ids, PAPER_LAMPS, strict=True)), LedGrid.radius, options.bag / 'beacons.yaml')


def make_drive(options: argparse.Namespace) -> tuple[LampDrive, list[int]]:
    """Return the drive that the options ask for, and the IDs of its lamps.

    Raises:
        SceneError: a file that is no waveform, an ID that is no number or there twice, not four lamps, a bad seed.
    """
    ids, waveforms = [], []
    for text in options.lamp:
        name, _, path = text.partition('=')
        if not name.isdecimal() or int(name) in ids or not path:
            raise SceneError(f'{text}: give each lamp as ID=FILE.csv, with a unique ID')
        ids.append(int(name))
        waveforms.append(_load(Path(path)))
    camera, rate, shape = (ROLLING, 30.0, Disc()) if options.shutter == 'rolling' else (GLOBAL, 60.0, LedGrid())
    drive = paper_run(waveforms, camera=camera, seed=options.seed, rest=REST, shape=shape)
    return replace(drive, clock=CameraClock(CLOCK_RATIO * rate, JITTER)), ids


def _load(path: Path) -> Waveform:
    try:
        return waveform_from_csv(path.read_text(encoding='utf-8'))
    except (LightWaveformError, UnicodeDecodeError) as error:
        raise SceneError(f'{path}: {error}') from error
    except OSError as error:
        raise SceneError(f'{path}: cannot be read ({error.strerror}); give a waveform file') from error


def write_beacons(lamps: Sequence[tuple[int, tuple[float, float, float]]], radius: float, path: Path) -> None:
    """Write the lamps, ID and place [m] of each, and their radius [m] as the beacons file that vlc_beacon takes.

    An existing file is replaced; raises `OSError`.
    """
    rows = [f'  - {{id: {beacon}, xyz: [{x}, {y}, {z}], radius: {radius}}}\n' for beacon, (x, y, z) in lamps]
    write_text(path, ''.join(['beacons:\n', *rows]))


def record_lamp_drive(drive: LampDrive, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive as a bag with ground truth; yield the number of each image after it is written.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive.
    """
    drive.frame_count(seconds)  # refuses a bad length
    images = (entry for frame in drive.frames(seconds) for entry in _image_entries(drive, frame))
    return write_drive(path, drive, seconds, '/image_raw/compressed', images)


def _image_entries(drive: LampDrive, frame: LampFrame) -> Iterator[Entry]:
    """Yield an image, its calibration and the true pose when its exposure began."""
    stamp = stamp_at(frame.stamp)
    truth = messages.pose_stamped(frame.pose, 'map', stamp)
    info = messages.camera_info(drive.camera.intrinsics, CAMERA_FRAME, stamp)
    image = messages.compressed_image(frame.photo.image, CAMERA_FRAME, stamp, JPEG_QUALITY, progressive=True)
    yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
    yield stamp, '/camera_info', 'sensor_msgs/msg/CameraInfo', info
    yield stamp, '/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', image
