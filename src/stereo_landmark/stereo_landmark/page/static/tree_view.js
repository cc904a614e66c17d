// The procedure tree: each path begins with one primitive, then searches the others around it.

import { activeTarget, app, changed } from './app.js';
import { COLOURS, el, svg } from './dom.js';

const ROWS_MAX = 7;
const [LEFT, TOP, COLUMN, ROW, NODE_W, NODE_H] = [118, 34, 164, 54, 136, 32];
const MARKS = {
  found: ['✓ found', 'var(--good)'], ambiguous: ['? could be confused', 'var(--weak)'], not_found: ['✗ not found', 'var(--stop)'],
  wrong_pose: ['✗ wrong position', 'var(--stop)'],
};

/** The tree, or its paths as a list where it is wider than `widthMax` [px]. */
export function treeView(widthMax) {
  const primitives = activeTarget().primitives;
  if (!primitives.length) return el('div', { className: 'empty' }, 'The tree shows the shapes that you select in step 2.');
  const rows = Math.min(primitives.length, ROWS_MAX);
  const trials = app.state.checks[app.state.active]?.trials;
  const width = LEFT + primitives.length * COLUMN + 130, height = TOP + rows * ROW + (primitives.length > rows ? 26 : 6);
  if (width + 20 > widthMax) return pathList(primitives, rows, trials);
  const drawing = svg('svg', { viewBox: `0 0 ${width} ${height}`, width, height, 'data-testid': 'tree' });
  const rootY = TOP + (rows * ROW) / 2 - ROW / 2 + NODE_H / 2;
  drawing.append(
    text('1st, in the whole image', LEFT + NODE_W / 2, 18, 'head'),
    ...primitives.slice(1).map((_, i) => text(i ? 'then' : 'then, in its window', LEFT + (i + 1) * COLUMN + NODE_W / 2, 18, 'head')),
  );
  for (let row = rows - 1; row >= 0; row -= 1) {
    const order = [primitives[row], ...primitives.filter((_, i) => i !== row)];
    const y = TOP + row * ROW + NODE_H / 2;
    const weight = Math.max(1, 6 - 1.1 * row);
    drawing.append(svg('path', {
      d: `M84 ${rootY}C${LEFT - 8} ${rootY} ${LEFT - 20} ${y} ${LEFT} ${y}`, class: 'branch', 'stroke-width': weight,
    }));
    order.forEach((primitive, column) => {
      const x = LEFT + column * COLUMN;
      if (column) drawing.append(svg('path', { d: `M${x - COLUMN + NODE_W} ${y}H${x}`, class: 'branch', 'stroke-width': Math.max(1, weight - 0.6 * column) }));
      drawing.append(node(primitive, primitives.indexOf(primitive) + 1, x, y));
    });
    drawing.append(...mark(trials, primitives, row, LEFT + primitives.length * COLUMN, y));
  }
  drawing.append(svg('rect', { x: 8, y: rootY - 17, width: 78, height: 34, rx: 17, class: 'root' }), text(activeTarget().name.slice(0, 11), 47, rootY + 4, 'root-name'));
  if (primitives.length > rows) drawing.append(text(`… and ${primitives.length - rows} more paths`, LEFT, height - 8, 'more'));
  return el('div', { className: 'tree' }, drawing);
}

function node(primitive, number, x, y) {
  const isSelected = primitive.name === app.selected;
  const group = svg('g', { class: `node${isSelected ? ' selected' : ''}`, onclick: () => { app.selected = isSelected ? null : primitive.name; changed(); } });
  const label = primitive.name.length > 14 ? `${primitive.name.slice(0, 9)}…${primitive.name.slice(-3)}` : primitive.name;
  group.append(
    svg('rect', { x, y: y - NODE_H / 2, width: NODE_W, height: NODE_H, rx: 8, stroke: COLOURS[primitive.kind] }),
    svg('circle', { cx: x + 16, cy: y, r: 9, fill: COLOURS[primitive.kind] }),
    text(String(number), x + 16, y + 4, 'number'), text(label, x + 30, y + 4, 'name'),
  );
  return group;
}

function pathList(primitives, rows, trials) {
  return el('ol', { className: 'paths', 'data-testid': 'tree' }, ...primitives.slice(0, rows).map((first, row) => {
    const [words, colour] = trials ? outcome(trials, primitives, row) : ['', ''];
    return el('li', {}, ...[first, ...primitives.filter((each) => each !== first)].map((each) => el('span', { className: 'node', style: { borderColor: COLOURS[each.kind] } }, each.name)),
      el('b', { style: { color: colour } }, words));
  }), primitives.length > rows && el('li', { className: 'more' }, `… and ${primitives.length - rows} more paths`));
}

/** Words and colour for the outcome of a path, which is used when all shapes before it are hidden. */
function outcome(trials, primitives, row) {
  const hidden = primitives.slice(0, row).map((primitive) => primitive.name).join('\n');
  const trial = trials.find((each) => each.hidden.join('\n') === hidden);
  return trial ? MARKS[trial.outcome] : ['too few shapes', 'var(--soft)'];
}

function mark(trials, primitives, row, x, y) {
  if (!trials) return [];
  const [words, colour] = outcome(trials, primitives, row);
  const label = text(words, x, y + 4, 'mark');
  label.style.fill = colour;
  return [label];
}

function text(words, x, y, name) {
  const made = svg('text', { x, y, class: name });
  made.textContent = words;
  return made;
}
