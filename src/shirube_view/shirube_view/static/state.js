// What the page knows: newest values by channel, and what is drawn from them.

import { seconds, yawOf } from './dom.js';

export const SOURCES = { floor_localizer: 'Floor', vlc_beacon: 'Lamps', stereo_landmark: 'Landmarks' };
const TRACK_MAX = 6000;

export const state = {};

export function clear() {
  Object.assign(state, {
    values: {}, grids: {}, track: [], truthTrack: [], fixes: { floor_localizer: [], vlc_beacon: [], stereo_landmark: [] },
    commands: [], diagnostics: {}, arrived: {}, time: null,
  });
}
clear();
Object.assign(state, { hello: null, status: {}, isOpen: false });

export const poseOf = (value) => {
  const pose = value?.pose?.pose ?? value?.pose;
  if (!pose || pose.position.x === null) return null;
  return { x: pose.position.x, y: pose.position.y, yaw: yawOf(pose.orientation), stamp: seconds(value.header.stamp) };
};

/** Newest pose of the robot: fused, else odometry alone is no pose in the map, so the true one or none. */
export const robot = () => poseOf(state.values.fused) ?? poseOf(state.values.truth);

function append(list, pose, least) {
  const last = list[list.length - 1];
  if (!pose || (last && Math.hypot(last.x - pose.x, last.y - pose.y) < least)) return;
  list.push(pose);
  if (list.length > TRACK_MAX) list.splice(0, TRACK_MAX / 10);
}

export async function take(values) {
  const now = performance.now();
  for (const [name, value] of Object.entries(values)) {
    state.arrived[name] = now;
    if (name.startsWith('diagnostics/')) state.diagnostics[value.name] = { ...value, arrived: now };
    else if (value.cells !== undefined) await takeGrid(name, value);
    else {
      state.values[name] = value;
      if (name === 'fused') append(state.track, poseOf(value), 0.01);
      if (name === 'truth') append(state.truthTrack, poseOf(value), 0.01);
      if (name in state.fixes) append(state.fixes[name], poseOf(value), 0.02);
      if (name === 'command') state.commands = [value.data, ...state.commands].slice(0, 6);
    }
  }
}

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Int8Array(await new Response(stream).arrayBuffer());
}

async function takeGrid(name, news) {
  const cells = await inflate(news.cells);
  const [height, width] = news.size;
  let grid = state.grids[name];
  if (!news.patch || !grid || grid.width !== width || grid.height !== height) {
    grid = { width, height, cells: new Int8Array(width * height).fill(-1) };
    state.grids[name] = grid;
  }
  Object.assign(grid, { origin: news.origin, resolution: news.resolution, picture: null });
  const [row, column] = news.corner;
  const [rows, columns] = news.shape;
  for (let r = 0; r < rows; r += 1) grid.cells.set(cells.subarray(r * columns, (r + 1) * columns), (row + r) * width + column);
}
