// Zones and lines: drawn, moved and shown. `state` is {shapes, chosen, drawing}; a shape is
// {kind, name, points, ...} as the site's file has it.
const REACH = 12; // how near the mouse meets a point or a line, pixels
const COLOUR = { zone: '#ff9bd2', line: '#9db8ff' };
const LEAST = { zone: 3, line: 2 };
export const MOST_POINTS = 100;

export class ZoneTool {
  constructor(state) {
    Object.assign(this, { state, held: null, mouse: null });
  }

  begin(kind) {
    this.state.chosen = -1;
    this.state.drawing = { kind, points: [] };
  }

  cancel() {
    this.state.drawing = this.held = null;
  }

  // End the drawing; a shape of too few points is none.
  finish() {
    const drawing = this.state.drawing;
    this.cancel();
    if (!drawing || drawing.points.length < LEAST[drawing.kind]) return;
    const names = this.state.shapes.map(({ name }) => name);
    let number = 1;
    while (names.includes(`${drawing.kind} ${number}`)) number += 1;
    this.state.shapes.push({ ...drawing, name: `${drawing.kind} ${number}` });
    this.state.chosen = this.state.shapes.length - 1;
  }

  remove(index) {
    this.state.shapes.splice(index, 1);
    this.state.chosen = -1;
  }

  // The mouse is pressed; return whether it met something.
  press(view, px, py) {
    const place = view.ground(px, py);
    if (this.state.drawing) return true;
    const { shapes, chosen } = this.state;
    if (shapes[chosen] && this.grip(view, shapes[chosen], px, py)) return true;
    for (let k = shapes.length - 1; k >= 0; k -= 1) {
      if (this.meets(view, shapes[k], px, py, place)) {
        this.state.chosen = k;
        this.held = { shape: shapes[k], from: place };
        return true;
      }
    }
    this.state.chosen = -1;
    return false;
  }

  // Hold a corner; between two of them, a new one.
  grip(view, shape, px, py) {
    const index = shape.points.findIndex((point) => away(view.pixel(...point), px, py) < REACH);
    if (index >= 0) {
      this.held = { shape, index };
      return true;
    }
    const middle = sides(shape).findIndex(
      ([a, b]) => away(view.pixel((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), px, py) < REACH,
    );
    if (middle < 0 || shape.points.length >= MOST_POINTS) return false;
    shape.points.splice(middle + 1, 0, view.ground(px, py));
    this.held = { shape, index: middle + 1 };
    return true;
  }

  glide(view, px, py) {
    const place = view.ground(px, py);
    this.mouse = place;
    const { held } = this;
    if (!held) return;
    if (held.index !== undefined) {
      held.shape.points[held.index] = place;
      return;
    }
    const [dx, dy] = [place[0] - held.from[0], place[1] - held.from[1]];
    held.shape.points = held.shape.points.map(([x, y]) => [x + dx, y + dy]);
    held.from = place;
  }

  // The mouse is let go where it was pressed (click), or elsewhere.
  release(view, px, py, is_click) {
    this.held = null;
    const { drawing } = this.state;
    if (!drawing || !is_click) return;
    const near = (point) => point && away(view.pixel(...point), px, py) < REACH;
    const { points } = drawing;
    if (points.length >= LEAST[drawing.kind]) {
      if (near(points[drawing.kind === 'zone' ? 0 : points.length - 1])) return this.finish();
    }
    if (near(points[points.length - 1]) || points.length >= MOST_POINTS) return;
    points.push(view.ground(px, py));
  }

  meets(view, shape, px, py, [x, y]) {
    if (shape.kind === 'line') {
      return sides(shape).some(([a, b]) => from_side(view.pixel(...a), view.pixel(...b), px, py)
        < REACH);
    }
    let inside = false;
    for (const [a, b] of sides(shape)) {
      const crosses = a[1] > y !== b[1] > y;
      if (crosses && x < ((b[0] - a[0]) * (y - a[1])) / (b[1] - a[1]) + a[0]) inside = !inside;
    }
    return inside;
  }

  paint(context, view, is_shown) {
    const { shapes, chosen, drawing } = this.state;
    if (is_shown) shapes.forEach((shape, k) => this.paint_shape(context, view, shape, k === chosen));
    if (drawing) {
      const points = this.mouse ? [...drawing.points, this.mouse] : drawing.points;
      this.paint_shape(context, view, { ...drawing, points, name: '' }, true);
    }
  }

  paint_shape(context, view, shape, is_chosen) {
    const pixels = shape.points.map((point) => view.pixel(...point));
    if (!pixels.length) return;
    const colour = COLOUR[shape.kind];
    context.beginPath();
    pixels.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (shape.kind === 'zone') {
      context.closePath();
      context.globalAlpha = is_chosen ? 0.22 : 0.12;
      context.fillStyle = colour;
      context.fill();
      context.globalAlpha = 1;
    }
    context.strokeStyle = colour;
    context.lineWidth = is_chosen ? 3 : 2;
    context.setLineDash(shape.kind === 'line' ? [10, 5] : []);
    context.stroke();
    context.setLineDash([]);
    if (is_chosen) {
      for (const [x, y] of pixels) dot(context, x, y, 5, '#ffffff');
      for (const [a, b] of sides({ ...shape, points: pixels })) {
        dot(context, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, 3, colour);
      }
    }
    if (shape.name) paint_name(context, shape, pixels, colour);
  }
}

function paint_name(context, shape, pixels, colour) {
  const is_line = shape.kind === 'line';
  const [left, right] = [Math.min, Math.max].map((of) => of(...pixels.map(([x]) => x)));
  const [x, y] = is_line ? pixels[0]
    : [(left + right) / 2, Math.min(...pixels.map((point) => point[1])) + 22];
  context.font = '600 12px system-ui, sans-serif';
  context.lineWidth = 3;
  context.lineJoin = 'round';
  context.strokeStyle = '#0c0f12';
  context.textAlign = 'center';
  context.strokeText(shape.name, x, y - 6);
  context.fillStyle = colour;
  context.fillText(shape.name, x, y - 6);
  context.textAlign = 'start';
}

function dot(context, x, y, radius, colour) {
  context.beginPath();
  context.arc(x, y, radius, 0, 7);
  context.fillStyle = colour;
  context.fill();
  context.strokeStyle = '#0c0f12';
  context.lineWidth = 1.5;
  context.stroke();
}

function sides({ kind, points }) {
  const pairs = points.slice(1).map((point, k) => [points[k], point]);
  return kind === 'zone' && points.length > 2 ? [...pairs, [points[points.length - 1], points[0]]]
    : pairs;
}

const away = ([x, y], px, py) => Math.hypot(x - px, y - py);

function from_side([ax, ay], [bx, by], px, py) {
  const length = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
  const share = Math.min(1, Math.max(0, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length));
  return Math.hypot(ax + (bx - ax) * share - px, ay + (by - ay) * share - py);
}
