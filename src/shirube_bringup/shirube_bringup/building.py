"""The robot's prior knowledge: dot map, lamps and their programs, taught places, command key."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.files.dot_map_file import write_indexed_map
from scene_simulator.commands.lamps import write_beacons
from scene_simulator.corridor.shapes import Landmark, RoundLandmark
from scene_simulator.corridor.stereo_rig import render_pair
from scene_simulator.mission.landmarks import FurnishedScene, bare_walls, landmarks_on_wall
from scene_simulator.mission.layout import FAST_LAMP, LAMP_RADIUS, LAMP_RATE, LAMPS, NOMINAL, SLOW_LAMP, surveyed_floor
from scene_simulator.mission.sensors import STEREO_RIG
from shirube_bringup.render_worker import compile_render_kernels, initialize_worker
from shirube_core.geometry import SE2
from shirube_core.waveform import Waveform
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind, invariant_points
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.files.place_file import save_place
from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.transmitter.lamp_program import RS_FSK_NAME, EncodingSettings, encode_packets
from vlc_beacon.core.transmitter.message_encoder import EncoderContext, encode_messages
from vlc_beacon.files.authorization_files import CounterFile

CRUISE_SPEED, SLOW_SPEED = 0.4, 0.22  # speed limits of the robot, at start and after the first command [m/s]
_MESSAGES = {SLOW_LAMP: ['id', f'slow:{SLOW_SPEED}'], FAST_LAMP: ['id', f'speed_up:{CRUISE_SPEED}']}
_COUNTER = 1
PLACES = {
    'east_near': (NOMINAL.goals[0], 'east'),
    'east_far': (SE2(4.4, 1.2, 0.0), 'east'),
    'north_near': (NOMINAL.goals[1], 'north'),
    'north_far': (SE2(6.3, 2.6, 0.5 * math.pi), 'north'),
    'west_near': (NOMINAL.goals[2], 'west'),
    'west_far': (SE2(3.6, 4.6, math.pi), 'west'),
}
"""Pose of the robot and visible wall of each taught place."""

_TOLERANCE = 3.0  # largest distance between the points of a detected primitive and those of its landmark [px]
_PUBLIC_KEY = 'b3' * 32
"""Key that signs the commands of the simulated lamps; fixed, so that a seed gives the same light. Not secret."""

_SURVEY_SIGMA = 5e-5  # standard deviation of the surveyed centres and diameters [m]


def lamp_waveforms(key: CommandKey) -> dict[int, Waveform]:
    """Return the waveform of each lamp by its ID, with commands signed by a key."""
    settings = EncodingSettings(code=RS_FSK_NAME, frame_rate=LAMP_RATE)
    waveforms = {}
    for name in LAMPS:
        packets = encode_messages(_MESSAGES.get(name, ['id']), EncoderContext(name, key, _COUNTER))
        waveforms[name] = encode_packets(packets, settings).waveform
    return waveforms


def teach_places(folder: Path) -> None:
    """Teach all places and write them to a folder.

    Raises:
        StereoLandmarkError: a place cannot be taught.
        OSError: the folder is not writable.
    """
    walls = bare_walls()
    rig = StereoRig(STEREO_RIG.left.intrinsics, STEREO_RIG.right.intrinsics, STEREO_RIG.baseline, STEREO_RIG.mount)
    for number, (name, (pose, wall)) in enumerate(PLACES.items()):
        camera_position = STEREO_RIG.camera_poses(pose)[0].position
        scene = FurnishedScene(walls).order_for_camera(camera_position)
        images = render_pair(scene, STEREO_RIG, pose, np.random.default_rng(number))
        processing = ImageProcessing()
        left, right = (detect_scene(image, processing) for image in images)
        teacher = Teacher(StereoView(left, right, rig), processing)
        visible = dict(_visible_landmarks(landmarks_on_wall(walls, wall), pose, StereoView(left, right, rig), teacher))
        place = teacher.teach(name, [TargetSelection('wall', visible)], pose)
        save_place(folder, place, StereoImages(*images))


def _visible_landmarks(
    landmarks: tuple[Landmark, ...], pose: SE2, view: StereoView, teacher: Teacher
) -> Iterator[tuple[str, Primitive]]:
    """Yield name and primitive of the landmarks that can be measured in both images."""
    for landmark in landmarks:
        found = _find_primitive(landmark, pose, view)
        if found is not None and teacher.can_measure(found):
            yield landmark.name.replace('/', ' '), found


def _find_primitive(landmark: Landmark, pose: SE2, view: StereoView) -> Primitive | None:
    """Return the primitive of a landmark in the left image, None if not found."""
    points_map = np.array(list(landmark.points_map().values()))
    points = STEREO_RIG.camera_poses(pose)[0].camera_points(points_map)
    truth = STEREO_RIG.left.intrinsics.pixels_from_points(points)
    kind = PrimitiveKind.ELLIPSE if isinstance(landmark, RoundLandmark) else PrimitiveKind.QUADRILATERAL
    best, smallest_error = None, _TOLERANCE
    for primitive in view.left.kinds[kind].primitives:
        named = primitive.image_points()
        found = np.array([named[name].position for name in invariant_points(primitive)])
        error = float(np.linalg.norm(found[:, None] - truth[None], axis=2).min(axis=1).max())
        if error < smallest_error:
            best, smallest_error = primitive, error
    return best


class BuildingFiles:
    """Paths of the files in a folder.

    Attributes:
        dot_map: indexed dot map.
        beacons: beacon file of the lamps.
        places: folder of the taught places.
        key: key that signs commands.
        counters: counters of the commands.
    """

    def __init__(self, folder: Path) -> None:
        """Set the folder."""
        self.dot_map, self.places = folder / 'floor.dotmap', folder / 'places'
        self.beacons, self.counters = folder / 'beacons.yaml', folder / 'counters.yaml'
        self.key = folder / 'mission.key'


def write_building(folder: Path) -> BuildingFiles:
    """Write the files that do not exist yet and return their paths.

    Args:
        folder: folder of the files, created if needed.

    Raises:
        OSError: the folder is not writable.
    """
    files = BuildingFiles(folder)
    files.places.mkdir(parents=True, exist_ok=True)
    if not files.dot_map.exists():
        floor = surveyed_floor()
        rng = np.random.default_rng(1)
        points = floor.points + rng.normal(0.0, _SURVEY_SIGMA, floor.points.shape)
        surveyed = DotMap(points, floor.diameters + rng.normal(0.0, _SURVEY_SIGMA, len(floor)))
        write_indexed_map(files.dot_map, surveyed, index_map(surveyed))
    write_beacons(list(LAMPS.items()), LAMP_RADIUS, files.beacons)
    if not any(files.places.glob('*.yaml')):
        teach_places(files.places)
    if not files.key.exists():
        files.key.touch(0o600)
        files.key.write_text(f'{_PUBLIC_KEY}\n')
    CounterFile(files.counters).reset(0)
    return files


def compile_kernels() -> None:
    """Render one image of each sensor."""
    initialize_worker(0, lamp_waveforms(CommandKey(bytes(32))))
    compile_render_kernels()
