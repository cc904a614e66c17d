"""Runs the teaching page."""

import argparse
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from shirube_core.geometry import CameraMount
from shirube_core.settings import check_settings
from shirube_ros.web.access import is_loopback, new_token, reachable_host
from shirube_ros.web.serving import serve
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.edits import TeachingState, rename_place, state_from_place
from stereo_landmark.files.place_file import load_place
from stereo_landmark.node_settings import NodeSettings
from stereo_landmark.page.drive_teaching import propose_from_drive
from stereo_landmark.page.page_server import PageServer
from stereo_landmark.page.pair_source import StereoPairs, bag_pairs, file_pairs, join_pairs, taught_pair
from stereo_landmark.page.place_saver import PlaceSaver
from stereo_landmark.page.request_handler import RequestHandler, SaveStatus

DRAFT_FOLDER = 'unsaved'
"""Subfolder of the places for unsaved drafts, which the localizer does not read."""


def open_page(options: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C.

    Raises:
        StereoLandmarkError: the image source or its first pair is invalid, or listening on the address failed.
        CameraFileError: a file is malformed.
        BagError: the bag is malformed.
        SettingsError: the camera mount is out of range.
    """
    _check_options(options)
    with _source(options) as source:
        if options.accept:
            propose_from_drive(source, options)
            return
        token = '' if is_loopback(options.host) else new_token()
        answers = _make_handler(source, options)
        answers.images(answers.session.state.pair)

        def print_address(port: int) -> None:
            host = reachable_host(options.host)
            query = f'?token={token}' if token else ''
            print(f'Teaching page: http://{host}:{port}/{query} (stop with Ctrl-C)', flush=True)  # noqa: T201

        try:
            serve(PageServer(answers, token), options.host, options.port, print_address)
        except OSError as fault:
            raise StereoLandmarkError(f'{fault.strerror}; choose another --host or --port') from fault
        finally:
            _save_draft(answers, options)


def _check_options(options: argparse.Namespace) -> None:
    """Check options early that would otherwise fail only when saving."""
    rename_place(TeachingState(), options.name)
    if not all(map(math.isfinite, options.tilt)):
        raise StereoLandmarkError('--tilt: roll and pitch must be finite angles [rad]; correct them')
    folder = _folder(options)
    existing = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not (existing.is_dir() and os.access(existing, os.W_OK | os.X_OK)):
        raise StereoLandmarkError(f'{folder}: is not writable; give another folder')


def _folder(options: argparse.Namespace) -> Path:
    """Return the folder for saving: that of the edited place; for a draft, its parent folder."""
    if options.place is None:
        return Path(options.places)
    folder: Path = options.place.parent
    return folder.parent if folder.name == DRAFT_FOLDER else folder


def _save_draft(answers: RequestHandler, options: argparse.Namespace) -> None:
    """Save unsaved changes as a draft and print its path."""
    if answers.save_status is not SaveStatus.UNSAVED:
        return
    name = answers.session.state.name
    try:
        path = PlaceSaver(_folder(options) / DRAFT_FOLDER).save(
            answers.session.draft(), answers.session.images, replace=True
        )
    except (StereoLandmarkError, OSError) as fault:
        print(f'teach: {name} was not saved, and no draft could be written: {fault}', file=sys.stderr)  # noqa: T201
        return
    print(f'teach: {name} was not saved; continue from the draft with: teach --place {path}', file=sys.stderr)  # noqa: T201


def _make_handler(source: StereoPairs, options: argparse.Namespace) -> RequestHandler:
    if options.drive is not None:
        proposal = propose_from_drive(source, options)
        state = replace(state_from_place(proposal.place), pair=proposal.taught)
        return RequestHandler(source, PlaceSaver(options.places), state, results=proposal.results)
    if options.place is None:
        return RequestHandler(source, PlaceSaver(options.places), TeachingState(name=options.name))
    folder = _folder(options)
    saver = PlaceSaver(folder, [options.place] if folder == options.place.parent else [])
    return RequestHandler(source, saver, state_from_place(load_place(options.place)))


@contextmanager
def _source(options: argparse.Namespace) -> Iterator[StereoPairs]:
    xyz, rpy = tuple(options.camera_xyz), tuple(options.camera_rpy)
    check_settings(NodeSettings(camera_xyz=xyz, camera_rpy=rpy))
    mount = CameraMount(xyz, rpy)
    if options.live:
        if options.test_bag:
            raise StereoLandmarkError('--test-bag needs recorded pairs; with --live capture further pairs')
        # Imported on demand: files and bags need no ROS.
        with import_module('stereo_landmark.page.live_pairs').live_pairs(options, mount) as source:
            yield source
        return
    yield _append_test_bags(_load_recorded(options, mount), options)


def _load_recorded(options: argparse.Namespace, mount: CameraMount) -> StereoPairs:
    if options.place is not None:
        return taught_pair(options.place)
    options.bag = options.bag or options.drive
    return bag_pairs(options, mount) if options.bag else file_pairs(options, mount)


def _append_test_bags(source: StereoPairs, options: argparse.Namespace) -> StereoPairs:
    if not options.test_bag:
        return source
    drives = [argparse.Namespace(**{**vars(options), 'bag': path}) for path in options.test_bag]
    return join_pairs(source, [(each.bag.name, bag_pairs(each, source.rig.mount)) for each in drives])
