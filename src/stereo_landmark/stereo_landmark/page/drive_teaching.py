"""``teach --drive``: proposes a place from a drive around it; the engineer accepts it, or changes it on the page."""

import argparse
import math
from collections.abc import Sequence

import numpy as np

from stereo_landmark.core.landmark_localizer import LandmarkFix
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.drive_proposal import DriveProposal, propose_place
from stereo_landmark.files.place_file import place_path, save_place
from stereo_landmark.page.pair_source import StereoPairs


def propose_from_drive(source: StereoPairs, options: argparse.Namespace) -> DriveProposal:
    """Propose a place, print what it achieves, and save it with ``--accept``.

    Raises:
        StereoLandmarkError: too little is in view, or the place exists and must not be replaced.
        OSError: the folder of the places is not writable.
    """
    file = place_path(options.places, options.name)
    if options.accept and file.exists() and not options.replace:
        raise StereoLandmarkError(f'{file} exists; give --replace, or another --name')
    proposal = propose_place(options.name, len(source.labels), source.images, source.rig, LandmarkSettings())
    print('\n'.join(describe(proposal, source.labels)))  # noqa: T201
    if options.accept:
        save_place(options.places, proposal.place, source.images(proposal.taught), replace_damaged=options.replace)
        print(f'{options.name} is taught; see {file}')  # noqa: T201
    return proposal


def describe(proposal: DriveProposal, labels: Sequence[str]) -> list[str]:
    """Return the lines that describe a proposal."""
    fixes = [each for each in proposal.results if isinstance(each, LandmarkFix)]
    lines = [f'taught at {labels[proposal.taught]}; shapes, and how often they are found again:']
    lines += [f'  {part:<24} {100.0 * share:3.0f} %' for part, share in proposal.recall.items()]
    lines.append('pair                     x m     y m   yaw °   sigma mm, °')
    for label, result in zip(labels, proposal.results, strict=True):
        if isinstance(result, LandmarkFix):
            fix = result.displacement
            pose, sigma = fix.T_place_base, 1e3 * fix.position_sigma
            lines.append(
                f'{label:<20} {pose.x:7.3f} {pose.y:7.3f} {math.degrees(pose.yaw):7.2f}   '
                f'{sigma:.1f}, {math.degrees(fix.yaw_sigma):.2f}'
            )
        else:
            lines.append(f'{label:<20} no pose: {result.reason}')
    lines.append(f'{len(fixes)} of {len(labels)} pairs give a pose')
    if fixes:
        low, high = proposal.poses.min(axis=0), proposal.poses.max(axis=0)
        turns = np.degrees([low[2], high[2]])
        lines.append(
            f'the robot finds itself from x {low[0]:.2f} to {high[0]:.2f} m, y {low[1]:.2f} to {high[1]:.2f} m, '
            f'yaw {turns[0]:.0f} to {turns[1]:.0f}° around the taught pose, as far as the drive shows'
        )
    return lines
