// Geometry of the image plane.

/** Distance of a point from a polyline [px]. */
export function distanceToLine(place, line) {
  let best = Infinity;
  for (let i = 1; i < line.length; i += 1) best = Math.min(best, distanceToSegment(place, line[i - 1], line[i]));
  return best;
}

function distanceToSegment([x, y], [ax, ay], [bx, by]) {
  const dx = bx - ax, dy = by - ay;
  const squared = dx * dx + dy * dy;
  const t = squared ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / squared)) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}

/** Centre of the bounding box of polylines. */
export function centreOf(lines) {
  const all = lines.flat();
  return [0, 1].map((axis) => (Math.min(...all.map((p) => p[axis])) + Math.max(...all.map((p) => p[axis]))) / 2);
}

const CLOSED_MIN = 4;
/** Hit radius of open shapes, as a fraction of the radius. */
const EXACT = 0.5;

/** Hit radius of the outline of a closed shape, which ranks before smaller shapes around the point. */
const ON_OUTLINE = 0.25;

/**
 * Shapes at a point, the most likely first: open shapes at the point, closed shapes with the outline at the point,
 * closed shapes around it, the smallest first, then near shapes.
 */
export function shapesAt(items, outlineOf, place, radius) {
  const ranked = [];
  for (const item of items) {
    const lines = outlineOf(item);
    const distance = Math.min(...lines.map((line) => distanceToLine(place, line)));
    const isClosed = lines.length === 1 && lines[0].length > CLOSED_MIN;
    if (!isClosed && distance <= EXACT * radius) ranked.push({ item, rank: 0, value: distance });
    else if (isClosed && distance <= ON_OUTLINE * radius) ranked.push({ item, rank: 1, value: distance });
    else if (isClosed && isInside(place, lines[0])) ranked.push({ item, rank: 2, value: areaOf(lines[0]) });
    else if (distance <= radius) ranked.push({ item, rank: 3, value: distance });
  }
  return ranked.sort((a, b) => a.rank - b.rank || a.value - b.value).map(({ item }) => item);
}

function isInside([x, y], line) {
  let inside = false;
  for (let i = 1; i < line.length; i += 1) {
    const [ax, ay] = line[i - 1], [bx, by] = line[i];
    if ((ay > y) !== (by > y) && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  }
  return inside;
}

function areaOf(line) {
  let sum = 0;
  for (let i = 1; i < line.length; i += 1) sum += line[i - 1][0] * line[i][1] - line[i][0] * line[i - 1][1];
  return Math.abs(sum) / 2;
}

/** Axes of the ellipse of a covariance [[a, b], [b, c]]: half lengths and the direction of the first. */
export function ellipseOf([[a, b], [, c]]) {
  const mean = (a + c) / 2, spread = Math.hypot((a - c) / 2, b);
  return { long: Math.sqrt(Math.max(mean + spread, 0)), short: Math.sqrt(Math.max(mean - spread, 0)),
    turn: 0.5 * Math.atan2(2 * b, a - c) };
}
