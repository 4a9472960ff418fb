// Where everybody is and was: messages decoded (frames.py tells their layout), paths kept by id.
const HEAD = 24, ROW = 48, BOX = 24;
const KEPT_S = 30; // of a path, live
const GAP_S = 1; // who was away for longer did not walk in between
const FAR_M = 2, FASTEST = 40; // nor did who comes farther than so many m, or faster, m/s
const GONE_S = 1.5; // without a message for so long, nobody is shown of the past
export const NOW = 1, PAST = 2, IMAGE = 3;
export const STATUS = ['tentative', 'confirmed', 'coasting', 'grouped', 'deleted'];
export const CLASSES = ['unknown', 'person', 'vehicle', 'bicycle', 'ball'];

export function headOf(buffer) {
  const view = new DataView(buffer);
  return {
    kind: view.getUint8(0), camera: view.getUint8(1), count: view.getUint32(4, true),
    time: view.getFloat64(8, true), until: view.getFloat64(16, true),
  };
}

export function rowsOf(buffer, head) {
  const view = new DataView(buffer);
  const rows = new Array(head.count);
  for (let k = 0, at = HEAD; k < head.count; k += 1, at += ROW) {
    const real = (place) => view.getFloat32(at + place, true);
    rows[k] = {
      id: view.getUint32(at, true), time: head.time + real(4), x: real(8), y: real(12),
      vx: real(16), vy: real(20), xx: real(24), xy: real(28), yy: real(32),
      group: view.getUint32(at + 36, true), cameras: view.getUint32(at + 40, true),
      status: view.getUint8(at + 44), class: view.getUint8(at + 45), kit: view.getUint8(at + 46),
      members: view.getUint8(at + 47),
    };
  }
  return rows;
}

export function imageOf(buffer, head) {
  const view = new DataView(buffer);
  const boxes = [];
  for (let k = 0, at = HEAD; k < head.count; k += 1, at += BOX) {
    const [left, top, width, height] = [0, 4, 8, 12].map((i) => view.getFloat32(at + i, true));
    const id = view.getUint32(at + 16, true);
    boxes.push({ left, top, width, height, id, members: view.getUint8(at + 20) });
  }
  return { boxes, blob: new Blob([new Uint8Array(buffer, HEAD + head.count * BOX)]) };
}

// A colour for every id, the same as in all images of this package (tracking/colours.py).
const colours = new Map();
export function colourOf(id) {
  let colour = colours.get(id);
  if (!colour) {
    const value = 0.95 - 0.2 * (Math.floor(id / 5) % 2);
    const hue = ((id * 0.6180339887) % 1) * 6;
    const [part, rest] = [Math.floor(hue) % 6, hue - Math.floor(hue)];
    const [p, q, t] = [1 - 0.72, 1 - 0.72 * rest, 1 - 0.72 * (1 - rest)].map((v) => v * value);
    const parts = [[value, t, p], [q, value, p], [p, value, t], [p, q, value], [t, p, value],
      [value, p, q]][part].map((v) => Math.round(255 * v));
    const light = parts.map((v) => Math.round(v + (255 - v) * 0.5));
    colour = { body: `rgb(${parts})`, faint: `rgba(${parts},0.16)`, label: `rgb(${light})` };
    if (colours.size > 5000) colours.clear();
    colours.set(id, colour);
  }
  return colour;
}

class Path {
  constructor() {
    this.time = [];
    this.x = [];
    this.y = [];
  }

  add(time, x, y) {
    this.time.push(time);
    this.x.push(x);
    this.y.push(y);
  }

  forget(before) {
    const count = this.time.findIndex((time) => time >= before);
    if (count < 64) return; // now and then suffices
    for (const list of [this.time, this.x, this.y]) list.splice(0, count);
  }

  // Whether somebody went from one point to a later one: was not away, nor taken for another.
  leads(from, to) {
    const gap = this.time[to] - this.time[from];
    const metres = Math.hypot(this.x[to] - this.x[from], this.y[to] - this.y[from]);
    return gap < GAP_S * Math.max(1, to - from) && metres < FAR_M + FASTEST * gap;
  }

  // The first index whose time is after a time.
  after(time) {
    let [low, high] = [0, this.time.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] > time) high = middle;
      else low = middle + 1;
    }
    return low;
  }

  at(time) {
    const next = this.after(time);
    if (next === 0) return [this.x[0], this.y[0]];
    const last = next - 1;
    if (next === this.time.length) return [this.x[last], this.y[last]];
    const gap = this.time[next] - this.time[last];
    const share = this.leads(last, next) ? (time - this.time[last]) / gap : 0;
    return [
      this.x[last] + (this.x[next] - this.x[last]) * share,
      this.y[last] + (this.y[next] - this.y[last]) * share,
    ];
  }
}

export class World {
  constructor() {
    this.clear();
  }

  clear() {
    this.paths = new Map();
    this.instants = []; // of the past: [time, rows]
    this.rows = []; // live
    this.newest = null; // time of the newest message
    this.period = 0.1;
    this.arrived = 0;
    this.from = this.until = null; // of the past that is known
  }

  // Take tracks of now.
  hear(head, rows, now) {
    const gap = this.newest === null ? 0 : head.time - this.newest;
    if (gap < -0.5 || gap > KEPT_S || this.from !== null) this.clear();
    if (gap > 0) this.period = Math.min(0.5, Math.max(0.02, gap));
    this.newest = head.time;
    this.arrived = now;
    this.rows = rows;
    for (const row of rows) this.path(row.id).add(head.time, row.x, row.y);
    for (const [id, path] of this.paths) {
      path.forget(head.time - KEPT_S);
      if (path.time[path.time.length - 1] < head.time - KEPT_S) this.paths.delete(id);
    }
  }

  // Take what is known around a time of the past, in the order of time.
  recall(head, rows) {
    this.clear();
    [this.from, this.until] = [head.time, head.until];
    for (const row of rows) {
      const last = this.instants[this.instants.length - 1];
      if (last && last[0] === row.time) last[1].push(row);
      else this.instants.push([row.time, [row]]);
      this.path(row.id).add(row.time, row.x, row.y);
    }
  }

  // The time that is drawn while it is live: a period late, so that everybody moves smoothly.
  clock(now) {
    if (this.newest === null) return null;
    return this.newest - this.period + Math.min(this.period, (now - this.arrived) / 1000);
  }

  is_moving(now) {
    return this.newest !== null && now - this.arrived < 1000 * this.period;
  }

  // Everybody at a time, at their places then.
  at(time) {
    let rows = this.rows;
    if (this.from !== null) {
      let [low, high] = [0, this.instants.length];
      while (low < high) {
        const middle = (low + high) >> 1;
        if (this.instants[middle][0] > time) high = middle;
        else low = middle + 1;
      }
      const instant = this.instants[low - 1];
      rows = instant && time - instant[0] < GONE_S ? instant[1] : [];
    }
    return rows.map((row) => {
      const [x, y] = this.path(row.id).at(time);
      return { ...row, x, y };
    });
  }

  path(id) {
    let path = this.paths.get(id);
    if (!path) this.paths.set(id, (path = new Path()));
    return path;
  }
}
