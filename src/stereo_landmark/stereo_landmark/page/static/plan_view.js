// Plan of the place from above: the taught pose, the targets, and the area in which tests found the robot.

import { app } from './app.js';
import { formatLength, svg } from './dom.js';

const MARGIN = 34;
/** Height of a line of text [px]. */
const LINE = 15;
/** Radius of the drawn robot [m]. */
const ROBOT = 0.2;
/** The plan shows at least this far around the robot [m]. */
const AROUND = 0.8;

/** Results of the tests of the current selection: found ones, and the number of the others. */
export function testedArea() {
  const tests = Object.entries(app.state.tests).map(([pair, test]) => ({ pair: Number(pair), ...test }));
  const found = tests.filter((test) => test.is_fix);
  return { tests, found, missing: tests.length - found.length };
}

/** What the tests say about the area, in one sentence. */
export function areaWords() {
  const { tests, found } = testedArea();
  if (!tests.length) return 'Nothing was tested yet: from where the robot will find itself is not known. Test all images of a drive around the place.';
  const count = `The robot found itself in ${found.length} of ${tests.length} tested ${tests.length === 1 ? 'image' : 'images'}`;
  if (!found.length) return `${count}.`;
  const range = (name) => [Math.min(...found.map((test) => test[name])), Math.max(...found.map((test) => test[name]))];
  const [x, y, yaw] = ['x', 'y', 'yaw'].map(range);
  const side = ([low, high], plus, minus) => [low, high].map((value) => `${Math.abs(value).toFixed(2)} m ${value < -0.005 ? minus : plus}`).join(' to ');
  const turn = yaw.map((value) => `${Math.round(Math.abs(value) * 180 / Math.PI)}° ${value < -0.009 ? 'right' : 'left'}`).join(' to ');
  return `${count}: from ${side(x, 'ahead', 'behind')}, ${side(y, 'left', 'right')}, turned by ${turn}. Outside of this area nothing was tested.`;
}

export function planView(width, height) {
  const { found } = testedArea();
  const targets = app.state.targets.map((target, k) => ({
    name: target.name, points: target.points.filter((point) => point.used).map((point) => point.xyz), isActive: k === app.state.active,
  })).filter((target) => target.points.length);
  const drawing = svg('svg', { class: 'plan', viewBox: `0 0 ${width} ${height}`, width, height, role: 'img', 'aria-label': `Plan from above. ${areaWords()}`, 'data-testid': 'plan' });
  const at = fit([...targets.flatMap((target) => target.points), ...found.map((test) => [test.x, test.y])], width, height);
  drawing.append(...grid(at, width, height), view(at, targets), ...area(at, found), ...targets.flatMap((target) => targetMarks(at, target)), ...targetNames(at, targets));
  drawing.append(...robot(at), ...found.filter((test) => !isShown(test)).map((test) => foundMark(at, test)), ...found.filter(isShown).map((test) => foundMark(at, test)));
  if (found.length) drawing.append(label(at([0, 0]), 'taught here', 'taught', ROBOT * at.scale + 14));
  return drawing;
}

/** Transform from the place's frame to the drawing: ahead is up, or right where the drawing is wide. */
function fit(points, width, height) {
  const isWide = width > height;
  const turned = ([x, y]) => (isWide ? [x, -y] : [-y, -x]);
  const corners = [...points, [-AROUND / 2, -AROUND], [AROUND, AROUND]].map(turned);
  const low = [0, 1].map((k) => Math.min(...corners.map((p) => p[k]))), high = [0, 1].map((k) => Math.max(...corners.map((p) => p[k])));
  const scale = Math.min((width - 2 * MARGIN) / (high[0] - low[0]), (height - 2 * MARGIN) / (high[1] - low[1]));
  const offset = [width, height].map((size, k) => size / 2 - scale * (low[k] + high[k]) / 2);
  const at = (place) => turned(place).map((value, k) => offset[k] + scale * value);
  return Object.assign(at, { scale, isWide });
}

const path = (at, places, name, isClosed = false) => svg('path', { d: `M${places.map((place) => at(place).map((v) => v.toFixed(1)).join(' ')).join('L')}${isClosed ? 'Z' : ''}`, class: name });

function label([x, y], words, name, below = 0) {
  const made = svg('text', { x, y: y + below, class: name });
  made.textContent = words;
  return made;
}

/** Lines of the floor, every metre or every five. */
function grid(at, width, height) {
  const step = at.scale > 26 ? 1 : 5;
  const reach = Math.ceil(Math.hypot(width, height) / at.scale / step) * step;
  const lines = [];
  for (let value = -reach; value <= reach; value += step) {
    lines.push(path(at, [[value, -reach], [value, reach]], 'floor'), path(at, [[-reach, value], [reach, value]], 'floor'));
  }
  const [x, y] = [12, height - 12];
  lines.push(svg('path', { d: `M${x} ${y - 5}V${y}H${x + step * at.scale}V${y - 5}`, class: 'scale' }), label([x + step * at.scale + 6, y + 1], `${step} m`, 'measure'));
  return lines;
}

/** What the left camera sees from the taught pose. */
function view(at, targets) {
  const { camera_xyz: eye, camera_rotation: rows, width, focal_length: f } = app.configuration;
  const reach = Math.max(1.5, ...targets.flatMap((target) => target.points.map(([x, y]) => Math.hypot(x, y)))) + 0.3;
  const corner = (side) => {
    const [x, y] = [0, 1].map((k) => rows[k][0] * side * width / f / 2 + rows[k][2]);
    const far = reach / Math.hypot(x, y);
    return [eye[0] + x * far, eye[1] + y * far];
  };
  return path(at, [[eye[0], eye[1]], corner(-1), corner(1)], 'view', true);
}

function robot(at) {
  const [x, y] = at([0, 0]);
  return [svg('circle', { cx: x, cy: y, r: ROBOT * at.scale, class: 'robot' }), path(at, [[0, 0], [1.6 * ROBOT, 0]], 'heading')];
}

function area(at, found) {
  const outline = hull(found.map((test) => [test.x, test.y]));
  return outline.length ? [path(at, outline, 'area', true)] : [];
}

const targetMarks = (at, { points, isActive }) => points.map((point) => at(point)).map(([x, y]) => svg('circle', { cx: x, cy: y, r: 3, class: `point${isActive ? ' on' : ''}` }));

/** Names of the targets, in front of their points and below each other where they would overlap. */
function targetNames(at, targets) {
  const places = targets.map(({ name, points }) => {
    const seen = points.map((point) => at(point));
    const mean = (k) => seen.reduce((sum, place) => sum + place[k], 0) / seen.length;
    return at.isWide ? { name, x: Math.min(...seen.map((place) => place[0])) - 10, y: mean(1) + 4 } : { name, x: mean(0), y: Math.max(...seen.map((place) => place[1])) + 18 };
  }).sort((a, b) => a.y - b.y);
  places.forEach((place, i) => { if (i) place.y = Math.max(place.y, places[i - 1].y + LINE); });
  return places.map(({ name, x, y }) => label([x, y], name, `target${at.isWide ? ' wide' : ''}`));
}

const isShown = (test) => test.pair === (app.testPair ?? app.state.pair);

function foundMark(at, test) {
  const [x, y] = at([test.x, test.y]);
  const tip = at([test.x + 14 / at.scale * Math.cos(test.yaw), test.y + 14 / at.scale * Math.sin(test.yaw)]);
  const group = svg('g', { class: `found${isShown(test) ? ' on' : ''}` }, svg('path', { d: `M${x} ${y}L${tip[0]} ${tip[1]}` }), svg('circle', { cx: x, cy: y, r: isShown(test) ? 5 : 3.5 }));
  const title = svg('title');
  title.textContent = `${app.state.pairs[test.pair]}: ± ${formatLength(test.position_sigma)}`;
  group.append(title);
  return group;
}

/** Convex hull of points (monotone chain). */
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = (list) => list.reduce((chain, point) => {
    while (chain.length > 1 && cross(chain.at(-2), chain.at(-1), point) <= 0) chain.pop();
    return [...chain, point];
  }, []).slice(0, -1);
  return sorted.length < 2 ? sorted : [...half(sorted), ...half(sorted.reverse())];
}
