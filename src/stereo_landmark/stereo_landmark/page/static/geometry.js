// Small geometry of the image plane.

/** Distance of a place from a polyline [px]. */
export function distanceToLine(place, line) {
  let best = Infinity;
  for (let i = 1; i < line.length; i += 1) best = Math.min(best, distanceToSegment(place, line[i - 1], line[i]));
  return best;
}

function distanceToSegment([x, y], [ax, ay], [bx, by]) {
  const dx = bx - ax, dy = by - ay;
  const squared = dx * dx + dy * dy;
  const share = squared ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / squared)) : 0;
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}

/** Mean of the places of some lines. */
export function middleOf(lines) {
  const all = lines.flat();
  return [0, 1].map((axis) => (Math.min(...all.map((p) => p[axis])) + Math.max(...all.map((p) => p[axis]))) / 2);
}

/** The outline nearest to a place, within a reach [px]; the smaller one where several are near. */
export function nearest(items, outlineOf, place, reach) {
  let best = null;
  for (const item of items) {
    const distance = Math.min(...outlineOf(item).map((line) => distanceToLine(place, line)));
    if (distance <= reach && (!best || distance < best.distance)) best = { item, distance };
  }
  return best?.item ?? null;
}

/** Axes of the ellipse of a covariance [[a, b], [b, c]]: half lengths and the direction of the first. */
export function ellipseOf([[a, b], [, c]]) {
  const mean = (a + c) / 2, spread = Math.hypot((a - c) / 2, b);
  return { long: Math.sqrt(Math.max(mean + spread, 0)), short: Math.sqrt(Math.max(mean - spread, 0)),
    turn: 0.5 * Math.atan2(2 * b, a - c) };
}
