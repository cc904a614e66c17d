// A technician's words for the reasons of the localizer.

const WORDS = {
  'no similar shapes in view': 'not in view: nothing like it was found. Is it hidden, out of the picture or too dark?',
  'the match could be due to chance': 'not clear enough: could be confused with another place',
  'ambiguous: several poses match': 'looks the same from more than one position: add a shape that makes the difference',
  'ambiguous: several places match': 'looks like another taught place: add a shape that makes the difference',
  'the taught view is not recognized': 'the robot does not recognize this view',
  'the pose is outside of the search region': 'too far away from the taught position, or turned too far',
  'too few points': 'too few of the taught points are visible',
  'left and right show the points in different rows; calibrate the cameras as a pair': 'the two cameras no longer fit together: calibrate them as a pair',
  'the distances between the points are not the taught ones': 'the shapes are not where they were: something was moved, or it is another object',
  'the points do not determine the displacement': 'the points are too close together to give a position',
  'the displacement is too uncertain': 'the position would be too uncertain: choose nearer shapes, or more of them',
};

/** Plain words for a reason of the localizer; an unknown reason stays as it is. */
export const plain = (reason) => WORDS[reason] ?? reason;

/** Names of what a test did not find, such as "door sign (quadrilateral 3)". */
export function missingNames(targets, found) {
  return targets.flatMap((target) => {
    const seen = found[target.name] ?? [];
    const missing = target.primitives.filter((each) => !each.fault && !seen.includes(each.name)).map((each) => each.name);
    return missing.length ? [`${target.name} (${missing.join(', ')})`] : [];
  });
}
