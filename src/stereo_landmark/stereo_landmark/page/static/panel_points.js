// Step 3: corresponding points in both images and in 3D (paper 4c).

import { activeTarget, edit } from './app.js';
import { formatAngle, el, kindIcon, formatLength } from './dom.js';
import { targetTabs } from './panel_targets.js';
import { plain } from './words.js';
import { stage } from './stage.js';

export function expectedPrecision(target) {
  const { expected } = target;
  if (!expected.is_fix) return el('p', { className: 'expected stop', 'data-testid': 'expected' }, el('b', {}, 'No position yet'), el('span', { title: expected.detail }, plain(expected.reason)));
  const isGood = expected.position_sigma <= 0.01 && expected.yaw_sigma <= 0.3 * Math.PI / 180;
  return el('p', { className: `expected ${isGood ? 'good' : 'weak'}`, 'data-testid': 'expected' },
    el('b', {}, `± ${formatLength(expected.position_sigma)}  ± ${formatAngle(expected.yaw_sigma)}`),
    el('span', {}, 'how exactly the robot will know its position and heading'));
}

function pointRow(point) {
  const [x, y, z] = point.xyz.map((value) => value.toFixed(3));
  const check = el('input', {
    type: 'checkbox', checked: point.used, 'data-testid': `point-${point.name}`,
    onchange: () => edit('set_points_used', { points: [point.name], used: check.checked }),
  });
  return el('tr', { className: point.used ? '' : 'unused', 'data-hover': point.name, onmouseenter: () => stage.hover(point.name), onmouseleave: () => stage.hover(null) },
    el('td', {}, el('label', {}, check, point.name.split('/').at(-1).replace('_', ' '))),
    el('td', {}, x), el('td', {}, y), el('td', {}, z), el('td', { className: point.sigma > 0.1 ? 'bad' : '' }, `± ${formatLength(point.sigma)}`));
}

function group(primitive) {
  const points = activeTarget().points.filter((point) => point.name.startsWith(`${primitive.name}/`));
  const names = points.map((point) => point.name);
  const areUsed = points.some((point) => point.used);
  return [
    el('tr', { className: 'group' }, el('th', { colSpan: 4 }, kindIcon(primitive.kind), primitive.name),
      el('th', {}, points.length > 1 && el('button', { className: 'quiet', onclick: () => edit('set_points_used', { points: names, used: !areUsed }) }, areUsed ? 'None' : 'All'))),
    ...(primitive.fault ? [el('tr', {}, el('td', { colSpan: 5, className: 'bad' }, primitive.fault))] : points.map(pointRow)),
  ];
}

export function panelPoints() {
  const target = activeTarget();
  const used = target.points.filter((point) => point.used).length;
  const table = el('table', { className: 'points', 'data-testid': 'points' },
    el('thead', {}, el('tr', {}, ...[`${used} of ${target.points.length}`, 'ahead', 'left', 'up', '±'].map((title) => el('th', {}, title)))),
    el('tbody', {}, ...target.primitives.flatMap(group)));
  return [
    el('h2', {}, 'Corresponding points'), targetTabs(),
    el('p', {}, 'The robot computes its position from these points. Exclude uncertain ones. Distances are in metres, from the robot as it stood when teaching.'),
    expectedPrecision(target),
    target.points.length ? table : el('p', { className: 'empty' }, 'Select shapes in step 2 first.'),
  ];
}
