// Part 3: the corresponding points, in both images and in space (paper 4c).

import { activeTarget, step } from './app.js';
import { COLOURS, degrees, el, kindIcon, millimetres } from './dom.js';
import { targetTabs } from './panel_targets.js';
import { stage } from './stage.js';

export function expectation(target) {
  const { expected } = target;
  if (!expected.is_fix) return el('p', { className: 'expected stop', 'data-testid': 'expected' }, el('b', {}, 'No pose yet'), el('span', {}, expected.text));
  const isGood = expected.position_sigma <= 0.01 && expected.yaw_sigma <= 0.3 * Math.PI / 180;
  return el('p', { className: `expected ${isGood ? 'good' : 'weak'}`, 'data-testid': 'expected' },
    el('b', {}, `± ${millimetres(expected.position_sigma)}  ± ${degrees(expected.yaw_sigma)}`),
    el('span', {}, 'is what these points promise for the robot (1 σ)'));
}

function pointRow(point) {
  const [x, y, z] = point.xyz.map((value) => value.toFixed(3));
  const check = el('input', {
    type: 'checkbox', checked: point.used, 'data-testid': `point-${point.name}`,
    onchange: () => step('use_points', { points: [point.name], used: check.checked }),
  });
  return el('tr', { className: point.used ? '' : 'unused', 'data-hover': point.name, onmouseenter: () => stage.hover(point.name), onmouseleave: () => stage.hover(null) },
    el('td', {}, el('label', {}, check, point.name.split('/').at(-1).replace('_', ' '))),
    el('td', {}, x), el('td', {}, y), el('td', {}, z), el('td', { className: point.sigma > 0.1 ? 'bad' : '' }, `± ${millimetres(point.sigma)}`));
}

function group(part) {
  const points = activeTarget().points.filter((point) => point.name.startsWith(`${part.name}/`));
  const names = points.map((point) => point.name);
  const areUsed = points.some((point) => point.used);
  return [
    el('tr', { className: 'group' }, el('th', { colSpan: 4 }, kindIcon(part.kind), el('span', { style: { color: COLOURS[part.kind] } }, part.name)),
      el('th', {}, points.length > 1 && el('button', { className: 'quiet', onclick: () => step('use_points', { points: names, used: !areUsed }) }, areUsed ? 'None' : 'All'))),
    ...(part.fault ? [el('tr', {}, el('td', { colSpan: 5, className: 'bad' }, part.fault))] : points.map(pointRow)),
  ];
}

export function panelPoints() {
  const target = activeTarget();
  const used = target.points.filter((point) => point.used).length;
  const table = el('table', { className: 'points', 'data-testid': 'points' },
    el('thead', {}, el('tr', {}, ...[`${used} of ${target.points.length}`, 'x ahead', 'y left', 'z up', '1 σ'].map((title) => el('th', {}, title)))),
    el('tbody', {}, ...target.primitives.flatMap(group)));
  return [
    el('h2', {}, 'Corresponding points'), targetTabs(),
    el('p', {}, 'The pose is made of these points. Leave out what is badly known. Coordinates are in metres, in the robot frame of the taught pose.'),
    expectation(target),
    target.points.length ? table : el('p', { className: 'empty' }, 'Choose primitives in part 2 first.'),
  ];
}
