// Draws the map: the ground once for each view, everybody again and again.
import { CLASSES, STATUS, colourOf } from 'mctrack-live/world.js';

const TRAIL_S = 6;
const FLASH_MS = 1800;
const FONT = '600 12px system-ui, sans-serif';
export const CAMERA_COLOURS = ['#ff8a80', '#ffd54f', '#81e68b', '#d0a3ff', '#5fe3e0', '#ff9bd2',
  '#ffb066', '#9db8ff'];
const HEALTH = { good: '#7dff9a', warning: '#ffc233', error: '#ff5252', silent: '#ff5252',
  waiting: '#8795a3' };
export const EVENT_COLOURS = { new: '#7dff9a', enter: '#7dff9a', exit: '#b4c0cb', merge: '#ffc233',
  split: '#ffc233', correction: '#57d3ff' };
export const colourOfEvent = (event) => EVENT_COLOURS[event] || '#ff9bd2';
export const healthColour = (level) => HEALTH[level] || HEALTH.waiting;

// A cut of the plane: centre in metres, pixels a metre, size in pixels; y goes up.
export class View {
  constructor() {
    Object.assign(this, { x: 0, y: 0, scale: 10, width: 1, height: 1, whole: true });
    this.bounds = [0, 0, 10, 10];
  }

  resize(width, height) {
    Object.assign(this, { width: Math.max(width, 1), height: Math.max(height, 1) });
    if (this.whole) this.show_all();
  }

  show_all() {
    const [left, low, right, high] = this.bounds;
    const margin = 1 + 2 * 0.06;
    this.x = (left + right) / 2;
    this.y = (low + high) / 2;
    this.scale = this.widest = Math.min(
      this.width / ((right - left) * margin), this.height / ((high - low) * margin),
    );
    this.whole = true;
  }

  zoom(factor, at) {
    const [x, y] = this.ground(...at);
    this.scale = Math.min(400, Math.max(this.widest * 0.3, this.scale * factor));
    this.x = x - (at[0] - this.width / 2) / this.scale;
    this.y = y + (at[1] - this.height / 2) / this.scale;
    this.whole = false;
  }

  centre(x, y) {
    Object.assign(this, { x, y, whole: false });
  }

  pixel(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  ground(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  get key() {
    return [this.x, this.y, this.scale, this.width, this.height].join();
  }
}

export class Painter {
  constructor(canvas, view) {
    Object.assign(this, { canvas, view, plan: null, frames: 0, drawn: [] });
    this.context = canvas.getContext('2d', { alpha: false });
    this.still = document.createElement('canvas');
    this.still_key = '';
  }

  // scene: ground, layers, cameras (levels by name), tracks, time, world, chosen, flashes, zones
  paint(scene, now) {
    const { context, view } = this;
    const dots = window.devicePixelRatio || 1;
    const [width, height] = [view.width, view.height].map((size) => Math.round(size * dots));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      Object.assign(this.canvas, { width, height });
    }
    const key = `${view.key}|${dots}|${scene.still}|${JSON.stringify(scene.layers)}`;
    if (key !== this.still_key) this.paint_still(scene, width, height, dots);
    this.still_key = key;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(this.still, 0, 0);
    context.setTransform(dots, 0, 0, dots, 0, 0);
    scene.zones.paint(context, view, scene.layers.zones);
    if (scene.layers.groups) this.paint_groups(scene);
    if (scene.layers.trails) this.paint_trails(scene);
    if (scene.layers.errors) this.paint_ellipses(scene);
    this.drawn = scene.tracks.map((track) => this.paint_track(track, scene));
    if (scene.layers.ids) this.paint_labels(scene);
    this.paint_flashes(scene, now);
    this.frames += 1;
  }

  line(context, points, closed = false) {
    context.beginPath();
    points.forEach(([x, y], k) => {
      const [px, py] = this.view.pixel(x, y);
      if (k) context.lineTo(px, py);
      else context.moveTo(px, py);
    });
    if (closed) context.closePath();
  }

  paint_still(scene, width, height, dots) {
    Object.assign(this.still, { width, height });
    const context = this.still.getContext('2d', { alpha: false });
    const { ground, layers } = scene;
    context.setTransform(dots, 0, 0, dots, 0, 0);
    context.fillStyle = '#191f26';
    context.fillRect(0, 0, this.view.width, this.view.height);
    if (ground.lines.length) this.paint_pitch(context, ground);
    else this.paint_floor(context, ground);
    if (layers.fields) ground.cameras.forEach((camera, k) => this.paint_field(context, camera, k));
    ground.cameras.forEach((camera, k) => this.paint_camera(context, camera, k, scene));
    this.paint_scale(context);
  }

  paint_floor(context, ground) {
    context.fillStyle = '#252d36';
    for (const ring of ground.area) {
      this.line(context, ring, true);
      context.fill();
    }
    if (this.plan) {
      const [left, low, right, high] = ground.plan.corners;
      const [[x0, y0], [x1, y1]] = [this.view.pixel(left, high), this.view.pixel(right, low)];
      context.drawImage(this.plan, x0, y0, x1 - x0, y1 - y0);
    } else {
      this.paint_grid(context);
    }
    context.strokeStyle = '#dfe5ea';
    context.lineWidth = 1.5;
    for (const ring of ground.area) {
      this.line(context, ring, true);
      context.stroke();
    }
  }

  paint_grid(context) {
    const [left, high] = this.view.ground(0, 0);
    const [right, low] = this.view.ground(this.view.width, this.view.height);
    const step = roundLength(70 / this.view.scale);
    context.strokeStyle = '#323c46';
    context.lineWidth = 1;
    for (let x = Math.ceil(left / step) * step; x < right; x += step) {
      this.line(context, [[x, low], [x, high]]);
      context.stroke();
    }
    for (let y = Math.ceil(low / step) * step; y < high; y += step) {
      this.line(context, [[left, y], [right, y]]);
      context.stroke();
    }
  }

  paint_pitch(context, ground) {
    const [[x0, y0], , [x1, y1]] = ground.lines[0];
    const grass = (left, right, margin, colour) => {
      const [[a, b], [c, d]] = [
        this.view.pixel(left, y1 + margin), this.view.pixel(right, y0 - margin),
      ];
      context.fillStyle = colour;
      context.fillRect(a, b, c - a, d - b);
    };
    grass(x0 - 3, x1 + 3, 3, '#1e3a2b');
    const stripes = 20;
    for (let k = 0; k < stripes; k += 1) {
      const edge = (share) => x0 + ((x1 - x0) * share) / stripes;
      grass(edge(k), edge(k + 1) + 0.02, 0, k % 2 ? '#26503a' : '#234934');
    }
    context.strokeStyle = 'rgba(235,242,238,0.75)';
    context.lineWidth = Math.max(1, 0.12 * this.view.scale);
    for (const line of ground.lines) {
      this.line(context, line);
      context.stroke();
    }
  }

  paint_field(context, camera, k) {
    const colour = CAMERA_COLOURS[k % CAMERA_COLOURS.length];
    for (const ring of camera.field) {
      this.line(context, ring, true);
      context.globalAlpha = 0.03;
      context.fillStyle = colour;
      context.fill();
      context.globalAlpha = 0.5;
      context.strokeStyle = colour;
      context.lineWidth = 1.2;
      context.stroke();
      context.globalAlpha = 1;
    }
  }

  // A camera where it stands; while all is shown, at least at the edge in its direction.
  paint_camera(context, camera, k, scene) {
    if (!camera.foot) return;
    const { width, height } = this.view;
    const [fx, fy] = this.view.pixel(...camera.foot);
    if (!this.view.whole && (fx < 0 || fx > width || fy < 0 || fy > height)) return;
    const is_whole = this.view.whole;
    const px = is_whole ? Math.min(width - 100, Math.max(16, fx)) : fx;
    const py = is_whole ? Math.min(height - 44, Math.max(52, fy)) : fy;
    const colour = CAMERA_COLOURS[k % CAMERA_COLOURS.length];
    context.fillStyle = '#0c0f12';
    context.strokeStyle = colour;
    context.lineWidth = 2;
    context.beginPath();
    context.roundRect(px - 8, py - 6, 16, 12, 3);
    context.fill();
    context.stroke();
    context.fillStyle = healthColour(scene.levels[camera.name]);
    context.beginPath();
    context.arc(px, py, 3, 0, 7);
    context.fill();
    this.text(context, camera.name, px + 12, py + 4, colour);
  }

  paint_scale(context) {
    const length = roundLength(90 / this.view.scale);
    const [y, px] = [this.view.height - 14, length * this.view.scale];
    context.strokeStyle = '#dfe5ea';
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(14, y - 5);
    context.lineTo(14, y);
    context.lineTo(14 + px, y);
    context.lineTo(14 + px, y - 5);
    context.stroke();
    this.text(context, `${length} m`, 20 + px, y + 1, '#dfe5ea');
  }

  text(context, text, x, y, colour) {
    context.font = FONT;
    context.lineWidth = 3;
    context.lineJoin = 'round';
    context.strokeStyle = '#0c0f12';
    context.strokeText(text, x, y);
    context.fillStyle = colour;
    context.fillText(text, x, y);
  }

  paint_groups({ tracks }) {
    const groups = new Map();
    for (const track of tracks) {
      if (track.group) groups.set(track.group, [...(groups.get(track.group) || []), track]);
    }
    const { context } = this;
    context.lineJoin = context.lineCap = 'round';
    context.strokeStyle = 'rgba(255,194,51,0.28)';
    context.lineWidth = Math.max(26, 2 * this.view.scale);
    for (const members of groups.values()) {
      const middle = this.view.pixel(mean(members, 'x'), mean(members, 'y'));
      context.beginPath();
      for (const { x, y } of members) {
        context.moveTo(...middle);
        context.lineTo(...this.view.pixel(x, y + 1e-3));
      }
      context.stroke();
    }
  }

  paint_trails({ tracks, world, time }) {
    const { context, view } = this;
    context.lineJoin = context.lineCap = 'round';
    for (const track of tracks) {
      const path = world.path(track.id);
      const [first, end] = [path.after(time - TRAIL_S), path.after(time)];
      context.strokeStyle = colourOf(track.id).body;
      const step = Math.max(1, Math.ceil((end - first) / 60));
      // three strokes, each shorter and stronger: a trail that fades
      for (const share of [0, 0.45, 0.75]) {
        context.globalAlpha = 0.32;
        context.lineWidth = 2 + share;
        context.beginPath();
        context.moveTo(...view.pixel(track.x, track.y));
        let later = end;
        for (let k = end - 1; k >= first + (end - first) * share; k -= step) {
          if (later < end && !path.leads(k, later)) break;
          later = k;
          context.lineTo(...view.pixel(path.x[k], path.y[k]));
        }
        context.stroke();
      }
    }
    context.globalAlpha = 1;
  }

  // Where somebody is with 95 %: two standard deviations and a half (chi-square of two, 5.99).
  paint_ellipses({ tracks }) {
    const { context, view } = this;
    context.lineWidth = 1;
    for (const { id, x, y, xx, xy, yy } of tracks) {
      const [half, lean] = [(xx + yy) / 2, Math.hypot((xx - yy) / 2, xy)];
      const [long, short] = [half + lean, Math.max(half - lean, 0)].map(
        (value) => Math.sqrt(5.99 * value) * view.scale,
      );
      if (!(long > 0) || long > 4000) continue;
      context.beginPath();
      context.ellipse(...view.pixel(x, y), long, short, -Math.atan2(2 * xy, xx - yy) / 2, 0, 7);
      context.fillStyle = colourOf(id).faint;
      context.fill();
      context.strokeStyle = colourOf(id).body;
      context.stroke();
    }
  }

  paint_track(track, { chosen }) {
    const { context, view } = this;
    const [px, py] = view.pixel(track.x, track.y);
    const colour = colourOf(track.id).body;
    const status = STATUS[track.status];
    const radius = Math.min(13, Math.max(5, 0.3 * view.scale)) * (status === 'tentative' ? 0.6 : 1);
    context.globalAlpha = status === 'coasting' || status === 'tentative' ? 0.65 : 1;
    if (track.id === chosen) {
      context.strokeStyle = '#ffffff';
      context.lineWidth = 2.5;
      context.beginPath();
      context.arc(px, py, radius + 6, 0, 7);
      context.stroke();
    }
    const speed = Math.hypot(track.vx, track.vy);
    if (speed > 0.3) {
      const length = Math.min(60, Math.max(radius + 6, speed * 0.8 * view.scale));
      context.strokeStyle = colour;
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(px, py);
      context.lineTo(px + (track.vx / speed) * length, py - (track.vy / speed) * length);
      context.stroke();
    }
    context.beginPath();
    this.outline(CLASSES[track.class], px, py, radius, track);
    context.fillStyle = status === 'coasting' ? '#191f26' : colour;
    context.fill();
    context.strokeStyle = status === 'coasting' ? colour : '#0c0f12';
    context.lineWidth = status === 'coasting' ? 2.5 : 1.5;
    context.stroke();
    context.globalAlpha = 1;
    return { ...track, px, py, radius };
  }

  outline(kind, px, py, radius, { vx, vy }) {
    const { context, view } = this;
    if (kind === 'vehicle') {
      const [long, wide] = [Math.max(10, 2.1 * view.scale), Math.max(5, 0.9 * view.scale)];
      const angle = Math.atan2(-vy, vx);
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      [[-1, -1], [1, -1], [1, 1], [-1, 1]].forEach(([a, b], k) => {
        const x = px + a * long * c - b * wide * s;
        const y = py + a * long * s + b * wide * c;
        if (k) context.lineTo(x, y);
        else context.moveTo(x, y);
      });
      context.closePath();
    } else if (kind === 'bicycle') {
      [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]].forEach(([a, b], k) => {
        if (k) context.lineTo(px + a * radius, py + b * radius);
        else context.moveTo(px + a * radius, py + b * radius);
      });
      context.closePath();
    } else {
      context.arc(px, py, kind === 'ball' ? radius * 0.6 : radius, 0, 7);
    }
  }

  // Dark figures on a light ground of the track's colour; who has no room for them has none.
  paint_labels({ chosen }) {
    const { context } = this;
    context.font = FONT;
    const taken = this.drawn.map(({ px, py, radius }) => [px - radius, py - radius, 2 * radius,
      2 * radius]);
    for (const track of this.drawn) {
      if (STATUS[track.status] === 'tentative' && track.id !== chosen) continue;
      const text = String(track.id) + (track.members > 1 ? ` +${track.members - 1}` : '');
      const [wide, high] = [context.measureText(text).width + 8, 16];
      const [off, { px, py }] = [track.radius + 2, track];
      const boxes = [
        [px + off, py - off - high + 4], [px - off - wide, py - off - high + 4],
        [px + off, py + off - 4], [px - off - wide, py + off - 4], [px - wide / 2, py - off - high],
        [px - wide / 2, py + off],
      ].map(([x, y]) => [x, y, wide, high]);
      const free = boxes.find((each) => !taken.some((other) => overlap(each, other)));
      if (!free && track.id !== chosen) continue;
      const box = free || boxes[0];
      taken.push(box);
      context.fillStyle = track.id === chosen ? '#ffffff' : colourOf(track.id).label;
      context.beginPath();
      context.roundRect(...box, 4);
      context.fill();
      context.fillStyle = '#0c0f12';
      context.fillText(text, box[0] + 4, box[1] + 12.5);
    }
  }

  paint_flashes({ flashes }, now) {
    const { context, view } = this;
    for (const flash of flashes) {
      const share = (now - flash.began) / FLASH_MS;
      if (share >= 1) continue;
      const [px, py] = view.pixel(...flash.place);
      context.globalAlpha = 1 - share;
      context.strokeStyle = flash.colour;
      context.lineWidth = 3;
      context.beginPath();
      context.arc(px, py, 8 + 34 * share, 0, 7);
      context.stroke();
      this.text(context, flash.text, px + 14, py + 24, flash.colour);
    }
    context.globalAlpha = 1;
  }
}

export const is_flashing = (flash, now) => now - flash.began < FLASH_MS;

const overlap = (a, b) => a[0] < b[0] + b[2] && b[0] < a[0] + a[2] && a[1] < b[1] + b[3]
  && b[1] < a[1] + a[3];

const mean = (rows, name) => rows.reduce((sum, row) => sum + row[name], 0) / rows.length;

// The largest of 1, 2 and 5 times a power of ten that is not longer, m.
function roundLength(metres) {
  const power = 10 ** Math.floor(Math.log10(metres));
  return Number((power * [5, 2, 1].find((each) => each * power <= metres)).toPrecision(1));
}
