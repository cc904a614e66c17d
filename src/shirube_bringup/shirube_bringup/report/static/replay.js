// Replay of the mission on a canvas: top view with robot, goals, obstacles, people and the pose of each source.
(() => {
  const mission = JSON.parse(document.getElementById('mission').textContent);
  const [canvas, play, seek, clock, speed, list, layers] = ['plan', 'play', 'seek', 'clock', 'speed', 'sources', 'layers'].map((id) => document.getElementById(id));
  const context = canvas.getContext('2d');
  const SOURCES = ['floor_localizer', 'vlc_beacon', 'stereo_landmark'];
  const NAMES = { truth: 'true', pose_arbiter: 'fused (pose_arbiter)', odometry: 'odometry alone', people: 'people' };
  const ZONES = { carpet: 'carpet: no dots', dark: 'lamps off', covered: 'landmarks covered' };
  const FRESH = 1.5; // a pose that is older is not drawn [s]
  const shown = { truth: true, pose_arbiter: true, floor_localizer: true, vlc_beacon: true, stereo_landmark: true, people: true, odometry: false };
  const margin = 0.15; // [m]
  const [x0, y0, x1, y1] = mission.room;
  let colours = {};
  let now = 0;
  let isPlaying = false;
  let before = 0;
  let scale = 1;
  const toPage = (x, y) => [(x - x0 + margin) * scale, (y1 - y + margin) * scale];

  function readColours() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ['ground', 'room', 'wall', 'ink', ...Object.keys(shown), ...Object.keys(ZONES)]) colours[name] = style.getPropertyValue(`--${name}`).trim();
  }

  /** Index of the last row whose time is not after a time, -1 for none. */
  function indexAt(rows, time) {
    let [low, high] = [0, rows.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (rows[middle][0] <= time) low = middle + 1; else high = middle;
    }
    return low - 1;
  }

  function box(low, high, style, alpha, isStroke = false) {
    const [[left, top], [right, bottom]] = [toPage(low[0], high[1]), toPage(high[0], low[1])];
    context.globalAlpha = alpha;
    context[isStroke ? 'strokeStyle' : 'fillStyle'] = style;
    context[isStroke ? 'strokeRect' : 'fillRect'](left, top, right - left, bottom - top);
    context.globalAlpha = 1;
  }

  function line(rows, last, style, width, dash = []) {
    context.beginPath();
    for (let k = 0; k <= last; k += 1) context.lineTo(...toPage(rows[k][1], rows[k][2]));
    context.setLineDash(dash);
    Object.assign(context, { strokeStyle: style, lineWidth: width, lineJoin: 'round' });
    context.stroke();
    context.setLineDash([]);
  }

  function circle(x, y, radius, style, isFilled, alpha = 1) {
    context.beginPath();
    context.arc(...toPage(x, y), radius * scale, 0, 2 * Math.PI);
    context.globalAlpha = alpha;
    if (isFilled) { context.fillStyle = style; context.fill(); } else { context.strokeStyle = style; context.stroke(); }
    context.globalAlpha = 1;
  }

  function heading([x, y, yaw], style, width) {
    const reach = mission.radius;
    context.beginPath();
    context.moveTo(...toPage(x, y));
    context.lineTo(...toPage(x + reach * Math.cos(yaw), y + reach * Math.sin(yaw)));
    Object.assign(context, { strokeStyle: style, lineWidth: width });
    context.stroke();
  }

  function text(words, x, y, style, align = 'center') {
    const size = Math.max(11, Math.min(15, 0.16 * scale));
    Object.assign(context, { font: `600 ${size}px system-ui, sans-serif`, textAlign: align, lineWidth: 3, strokeStyle: colours.room, fillStyle: style });
    const [px, py] = toPage(x, y);
    context.strokeText(words, px, py);
    context.fillText(words, px, py);
  }

  function drawRoom() {
    box([x0, y0], [x1, y1], colours.room, 1);
    for (const [name, low, high] of mission.zones) box(low, high, colours[name], 0.16);
    for (const [left, low, right, high] of mission.boxes) box([left, low], [right, high], colours.wall, 1);
    context.lineWidth = 2;
    box([x0, y0], [x1, y1], colours.wall, 1, true);
    for (const [name, low, high] of mission.zones) text(ZONES[name] ?? name, (low[0] + high[0]) / 2, low[1] + 0.08, colours[name]);
  }

  function drawGoals() {
    mission.stops.forEach((stop, k) => {
      const leg = mission.legs[k - 1];
      const [isDone, isNext] = [leg && now >= leg[1], leg && now >= leg[0] && now < leg[1]];
      context.lineWidth = isNext ? 3 : 1.2;
      circle(stop[0], stop[1], mission.radius, colours.ink, false);
      heading(stop, colours.ink, isNext ? 3 : 1.2);
      text(k ? `goal ${k}${isDone ? ' ✓' : ''}` : 'start', stop[0], stop[1] + 1.25 * mission.radius, colours.ink);
    });
  }

  function drawPoses() {
    if (shown.truth) line(mission.truth, indexAt(mission.truth, now), colours.truth, 5);
    for (const name of ['odometry', 'pose_arbiter']) {
      if (shown[name] && mission.poses[name]) line(mission.poses[name], indexAt(mission.poses[name], now), colours[name], 1.6, name === 'odometry' ? [5, 4] : []);
    }
    for (const name of SOURCES) {
      const rows = mission.poses[name] ?? [];
      if (shown[name]) for (let k = indexAt(rows, now); k >= 0 && rows[k][0] > now - 8; k -= 1) circle(rows[k][1], rows[k][2], 0.025, colours[name], true, 1 - (now - rows[k][0]) / 9);
    }
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    scale = width / (x1 - x0 + 2 * margin);
    const height = (y1 - y0 + 2 * margin) * scale;
    canvas.style.height = `${height}px`;
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, width, height);
    drawRoom();
    drawGoals();
    drawPoses();
    const step = Math.max(0, indexAt(mission.truth, now));
    if (shown.people) for (const [x, y] of mission.people[step] ?? []) { circle(x, y, 0.25, colours.people, true, 0.35); context.lineWidth = 2; circle(x, y, 0.25, colours.people, false); }
    const robot = mission.truth[step].slice(1);
    circle(robot[0], robot[1], mission.radius, colours.truth, true, 0.3);
    context.lineWidth = 2.5;
    circle(robot[0], robot[1], mission.radius, colours.truth, false);
    heading(robot, colours.truth, 3);
    for (const name of [...SOURCES, 'pose_arbiter']) {
      const row = mission.poses[name]?.[indexAt(mission.poses[name], now)];
      if (!shown[name] || !row || now - row[0] > FRESH) continue;
      circle(row[1], row[2], name === 'pose_arbiter' ? 0.07 : 0.05, colours[name], true);
      heading(row.slice(1), colours[name], 2);
    }
    say();
  }

  function say() {
    clock.textContent = `${now.toFixed(1)} s`;
    seek.value = now;
    const leg = mission.legs.findIndex(([begin, end]) => now >= begin && now < end);
    seek.setAttribute('aria-valuetext', `${now.toFixed(0)} seconds${leg < 0 ? '' : `, to goal ${leg + 1}`}`);
    for (const item of list.children) {
      const status = mission.status[item.dataset.name]?.[Math.floor(now)] ?? '';
      const words = item.querySelector('span');
      words.textContent = status || 'no poses';
      words.className = status === 'used' ? 'good' : status ? 'weak' : 'soft';
    }
  }

  function start(isOn) {
    isPlaying = isOn;
    play.textContent = isOn ? '❚❚' : '▶';
    play.setAttribute('aria-label', isOn ? 'Pause' : 'Play');
    if (isOn && now >= mission.end) now = 0;
    before = performance.now();
    if (isOn) requestAnimationFrame(advance);
  }

  function advance(time) {
    if (!isPlaying) return;
    now = Math.min(mission.end, now + Math.max(0, time - before) * Number(speed.value) / 1000);
    before = time;
    draw();
    if (now >= mission.end) start(false); else requestAnimationFrame(advance);
  }

  for (const name of SOURCES) {
    const item = document.createElement('li');
    item.dataset.name = name;
    item.style.borderColor = `var(--${name})`;
    item.append(Object.assign(document.createElement('b'), { textContent: name }), document.createElement('span'));
    list.append(item);
  }
  for (const name of Object.keys(shown)) {
    const [label, box_, dot] = ['label', 'input', 'i'].map((kind) => document.createElement(kind));
    Object.assign(box_, { type: 'checkbox', checked: shown[name], onchange: () => { shown[name] = box_.checked; draw(); } });
    dot.style.background = `var(--${name})`;
    label.append(box_, dot, NAMES[name] ?? name);
    layers.append(label);
  }
  seek.max = mission.end;
  seek.oninput = () => { start(false); now = Number(seek.value); draw(); };
  play.onclick = () => start(!isPlaying);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { readColours(); draw(); });
  new ResizeObserver(draw).observe(canvas.parentElement);
  readColours();
  draw();
  if (!matchMedia('(prefers-reduced-motion: reduce)').matches) start(true);
  window.__replay = { get time() { return now; } };
})();
