// The live map: a canvas with everybody on it, and what goes with it.
import { Link } from 'mctrack-live/link.js';
import {
  CAMERA_COLOURS, Painter, View, colourOfEvent, healthColour, is_flashing,
} from 'mctrack-live/painter.js';
import {
  CLASSES, PAST, STATUS, World, colourOf, imageOf, rowsOf,
} from 'mctrack-live/world.js';
import { ZoneTool } from 'mctrack-live/zones.js';

const FRAME_MS = 30; // between two drawings at least
const REACH = 14; // how near a click meets a track, pixels
const STILL = 5; // what the mouse may move during a click, pixels
const MOST_EVENTS = 200;
const TRAIL_S = 7; // what is to be known of the past before the instant that is shown
const MOST_PICTURES = 3; // of one who is followed
const SEEN_MS = 1500;
const NO_FLASH = ['feedback_missed', 'stable', 'occupancy'];
const ZONE_WORDS = { enter_zone: 'enters %', leave_zone: 'leaves %', dwell: 'dwells in %',
  cross_left: 'crosses % to its left', cross_right: 'crosses % to its right' };
const LAYERS = { ids: 'ids', trails: 'trails', errors: '95 % ellipses', groups: 'groups',
  fields: 'fields of view', zones: 'zones' };
const KEPT = 'mctrack-map';

export default {
  template: `
    <div class="map-sheet">
      <header class="map-bar">
        <span class="title">{{ title }}</span>
        <button class="badge" :class="badge.kind" @click="go_live" :disabled="!ground.live"
                :title="badge.hint">{{ badge.text }}</button>
        <span class="hint" role="status">{{ notice }}</span>
        <form class="search" @submit.prevent="search">
          <input v-model="wanted" inputmode="numeric" maxlength="10" placeholder="Find id"
                 aria-label="Find id" />
        </form>
      </header>
      <div class="pane stage" ref="stage">
        <canvas ref="canvas" tabindex="0" :class="cursor" @wheel.prevent="wheel"
                @pointerdown="press" @pointermove="glide" @pointerup="release"
                @pointercancel="pointers.clear()" @pointerleave="tool.mouse = null; touch()"
                @dblclick="tool.finish()" @keydown="key"></canvas>
        <div class="layers" :class="{ open: menu }">
          <button class="menu" :aria-pressed="menu" @click="menu = !menu">layers</button>
          <button v-for="(label, name) in LAYERS" :key="name" :class="{ on: layers[name] }"
                  :aria-pressed="layers[name]" @click="toggle(name)">{{ label }}</button>
        </div>
        <div class="zoom">
          <button title="Closer" @click="zoom(1.5)">+</button>
          <button title="Farther" @click="zoom(1 / 1.5)">−</button>
          <button title="Show all" @click="show_all">⤢</button>
        </div>
        <div class="who" v-if="chosen" :style="{ borderColor: colour(chosen) }">
          <div class="line"><b :style="{ color: colour(chosen) }">{{ chosen }}</b>
            <span>{{ who ? who.kind : 'not here now' }}</span>
            <button class="tiny" @click="follow = !follow; keep()" :class="{ on: follow }"
                    :aria-pressed="follow">follow</button>
            <button class="tiny" aria-label="Let go" @click="choose(0)">×</button></div>
          <div class="line faint" v-if="who">{{ who.text }}</div>
          <div class="line faint" v-if="who">seen by {{ who.seen || 'no camera' }}</div>
        </div>
      </div>
      <footer class="timeline" v-if="past.ended">
        <button @click="play" :aria-label="playing ? 'Pause' : 'Play'">{{ playing ? '❚❚' : '▶' }}
        </button>
        <button @click="speed = speed === 1 ? 4 : speed === 4 ? 16 : 1" title="Speed">{{ speed }}×
        </button>
        <div class="track">
          <i v-for="mark in marks" :style="{ left: mark.left, background: mark.colour }"></i>
          <input type="range" aria-label="Time" :min="past.began" :max="end" step="0.04"
                 :value="shown_time" @input="seek(Number($event.target.value))" />
        </div>
        <span class="clock"><i>{{ clock.at }}</i> {{ clock.since }}</span>
        <button class="live" v-if="ground.live" :class="{ on: is_live }" @click="go_live">live
        </button>
      </footer>
      <footer class="timeline empty" v-else-if="past.text">No past: {{ past.text }}</footer>
      <aside class="map-side">
        <section class="pane list cameras" v-if="parts.length">
          <h2>Cameras</h2>
          <div v-for="(part, k) in parts" :key="part.name" class="camera">
            <button class="row" :class="{ on: shown.includes(part.name) }"
                    :disabled="part.name === 'tracker' || !ground.live"
                    :aria-label="'Show ' + part.name" @click="show(part.name)">
              <i class="dot" :style="{ background: part.colour }"></i>
              <span :style="{ color: camera_colour(k, part) }">{{ part.name }}</span>
              <span class="faint grow">{{ part.text || part.level }}</span>
              <span class="faint">{{ part.rate && part.rate + ' Hz' }}</span>
            </button>
            <canvas v-if="shown.includes(part.name)" :data-camera="part.name" class="picture"
                    :class="{ big: part.name === big }" width="320" height="240"
                    @click="big = part.name === big ? '' : part.name"></canvas>
          </div>
        </section>
        <section class="pane list lower">
          <nav><button :class="{ on: tab === 'events' }" @click="tab = 'events'">Events</button>
            <button :class="{ on: tab === 'tracks' }" @click="tab = 'tracks'">
              Tracks {{ listed.length || '' }}</button>
            <button :class="{ on: tab === 'zones' }" @click="tab = 'zones'">Zones</button></nav>
          <div class="rows" v-if="tab === 'events'">
            <button v-for="event in events_shown" :key="event.key" class="row event"
                    @click="open_event(event)">
              <i class="dot" :style="{ background: event.colour }"></i>
              <span class="faint">{{ event.at }}</span><span class="grow">{{ event.text }}</span>
            </button>
            <p v-if="!events_shown.length" class="faint">Nothing has happened yet.</p>
          </div>
          <div class="rows" v-else-if="tab === 'tracks'">
            <button v-for="track in listed" :key="track.id" class="row"
                    :class="{ on: track.id === chosen }" @click="choose(track.id, true)">
              <i class="dot" :style="{ background: colour(track.id) }"></i>
              <b>{{ track.id }}</b><span class="grow faint">{{ track.text }}</span>
            </button>
            <p v-if="!listed.length" class="faint">Nobody is here.</p>
          </div>
          <div class="rows" v-else>
            <div class="tools" v-if="ground.editable">
              <button @click="draw('zone')" :class="{ on: drawing === 'zone' }">+ zone</button>
              <button @click="draw('line')" :class="{ on: drawing === 'line' }">+ line</button>
              <button v-if="drawing" @click="tool.finish(); touch()">done</button>
              <span class="grow"></span>
              <button :disabled="!is_changed" @click="discard">discard</button>
              <button class="save" :disabled="!is_changed" @click="save">save</button>
            </div>
            <div v-for="(shape, k) in zones.shapes" :key="k" class="row zone"
                 :class="{ on: k === zones.chosen }" @click="zones.chosen = k; touch()">
              <i class="dot" :class="shape.kind"></i>
              <input v-model="shape.name" maxlength="64" :aria-label="'Name of ' + shape.kind"
                     :disabled="!ground.editable" @input="touch()" />
              <button class="tiny" v-if="ground.editable" :aria-label="'Delete ' + shape.name"
                      @click.stop="tool.remove(k); touch()">×</button>
            </div>
            <p v-if="!zones.shapes.length" class="faint">{{ ground.editable
              ? 'Draw a zone or a line: click its corners on the map; the first one closes a zone.'
              : 'This site has no zones.' }}</p>
          </div>
        </section>
      </aside>
    </div>`,
  props: { title: String, socket: String },
  data: () => ({
    LAYERS,
    ground: { live: false, editable: false, cameras: [] },
    is_open: false,
    is_live: true,
    playing: false,
    speed: 1,
    notice: '',
    wanted: '',
    chosen: 0,
    follow: false,
    who: null,
    layers: { ids: true, trails: true, errors: false, groups: true, fields: true, zones: true },
    parts: [],
    shown: [],
    big: '',
    menu: false,
    tab: 'events',
    events: [],
    listed: [],
    count: 0,
    rate: 0,
    has_come: false,
    past: {},
    shown_time: 0,
    zones: { shapes: [], chosen: -1, drawing: null },
    saved: '[]',
    moving: false,
  }),
  computed: {
    badge() {
      if (!this.is_open) return { kind: 'lost', text: 'no connection', hint: 'The server is away' };
      if (!this.is_live) {
        const hint = this.ground.live ? 'Back to live' : 'A recording';
        return { kind: 'past', text: this.ground.live ? 'past' : 'recording', hint };
      }
      if (!this.rate) {
        const hint = 'Nothing comes on /tracks';
        return this.has_come ? { kind: 'lost', text: 'no tracks', hint }
          : { kind: 'waiting', text: 'waiting for tracks', hint };
      }
      const tracks = `${this.count} track${this.count === 1 ? '' : 's'}`;
      return { kind: 'live', text: `live · ${tracks} · ${this.rate} Hz`, hint: '' };
    },
    cursor() {
      return { placing: this.zones.drawing !== null, dragging: this.moving };
    },
    drawing() {
      return this.zones.drawing && this.zones.drawing.kind;
    },
    is_changed() {
      return JSON.stringify(this.zones.shapes) !== this.saved;
    },
    end() {
      return this.past.ended;
    },
    clock() {
      const at = this.shown_time;
      return at ? { at: clock_text(at), since: length_text(at - this.past.began) } : {};
    },
    events_shown() {
      const until = this.is_live ? Infinity : this.shown_time;
      return this.events.filter(({ time }) => time <= until).slice(-MOST_EVENTS).reverse();
    },
    marks() {
      const [began, length] = [this.past.began, this.end - this.past.began || 1];
      return this.events.filter(({ time }) => time >= began && time <= this.end).map((event) => ({
        left: `${(100 * (event.time - began)) / length}%`, colour: event.colour,
      }));
    },
  },
  created() {
    Object.assign(this, {
      world: new World(), view: new View(), levels: {}, flashes: [], still: 0, dirty: true,
      pointers: new Map(), seen: new Map(), arrivals: [], asked: null, asking: false, number: 0,
      played: 0, tracks: [], last: 0, bits: [], tool: new ZoneTool(this.zones), bitmaps: {},
    });
    this.recall_view();
  },
  mounted() {
    this.painter = new Painter(this.$refs.canvas, this.view);
    this.observer = new ResizeObserver(() => {
      this.view.resize(this.$refs.stage.clientWidth, this.$refs.stage.clientHeight);
      this.touch();
    });
    this.observer.observe(this.$refs.stage);
    const told = (message) => {
      const name = `told_${message.kind}`;
      if (this[name]) this[name](message);
    };
    this.link = new Link(this.socket, {
      told,
      frame: (head, buffer) => this.take_frame(head, buffer),
      image: (head, buffer) => this.take_image(head, buffer),
      open: () => {
        this.is_open = true;
        this.asking = false;
      },
      lost: () => {
        this.is_open = false;
      },
    });
    const state = () => this.state();
    window.mctrackMap = Object.freeze({ get state() { return state(); } });
    this.beat = setInterval(() => this.look(), 500);
    const loop = (now) => {
      this.next = requestAnimationFrame(loop);
      this.draw_frame(now);
    };
    this.next = requestAnimationFrame(loop);
  },
  beforeUnmount() {
    cancelAnimationFrame(this.next);
    clearInterval(this.beat);
    this.observer.disconnect();
    this.link.close();
  },
  methods: {
    // What was drawn last, for tests.
    state() {
      const { painter, view } = this;
      return {
        mode: this.is_live ? 'live' : 'past', is_open: this.is_open, time: this.time,
        frames: painter.frames, centre: [view.x, view.y], scale: view.scale,
        chosen: this.chosen, shown: [...this.shown],
        tracks: painter.drawn.map(({ id, x, y, px, py, group }) => ({ id, x, y, px, py, group })),
        flashes: this.flashes.length, pictures: Object.keys(this.bitmaps),
        zones: JSON.parse(JSON.stringify(this.zones.shapes)),
        pixel: (x, y) => view.pixel(x, y),
      };
    },
    touch() {
      this.dirty = true;
    },
    // What the server tells.
    told_ground(ground) {
      const before = this.ground.bounds;
      this.ground = ground;
      this.bits = ground.cameras.map(({ name }) => name);
      if (ground.bounds && String(before) !== String(ground.bounds)) {
        this.view.bounds = ground.bounds;
        this.view.show_all();
      }
      if (ground.plan && !this.painter.plan) {
        const plan = new Image();
        plan.onload = () => {
          this.painter.plan = plan;
          this.still += 1;
          this.touch();
        };
        plan.src = ground.plan.address;
      }
      this.still += 1;
      if (!ground.live) this.is_live = false;
      else if (!this.is_live) this.seek(this.shown_time);
      this.ask_pictures();
      this.touch();
    },
    told_cameras({ names }) {
      this.bits = names;
    },
    told_events({ lines }) {
      if (!this.is_live && this.ground.live) return;
      this.add_events(lines);
      if (lines.length > 30) return; // what was before this window opened
      for (const line of lines) this.flash(line);
    },
    told_health({ parts }) {
      const levels = Object.fromEntries(parts.map(({ name, level }) => [name, level]));
      if (JSON.stringify(levels) !== JSON.stringify(this.levels)) this.still += 1;
      this.levels = levels;
      this.parts = parts.map((part) => ({ ...part, colour: healthColour(part.level) }));
      this.touch();
    },
    told_past(past) {
      const first = !this.past.ended;
      this.past = past;
      if (first && past.ended && !this.ground.live) {
        this.seek(past.began + Math.min(2, past.ended - past.began));
        this.playing = true;
      }
    },
    told_block({ events }) {
      this.events = [];
      this.add_events(events);
    },
    told_found({ track, time }) {
      if (time === null) {
        this.tell(`Nobody was ever called ${track}`);
        return;
      }
      this.choose(track);
      this.seek(time);
      this.tell(`${track} was seen last at ${clock_text(time)}`);
    },
    told_zones({ shapes }) {
      const was_changed = this.is_changed;
      this.saved = JSON.stringify(shapes);
      if (!was_changed) this.zones.shapes = shapes;
      this.touch();
    },
    told_saved({ text }) {
      this.saved = JSON.stringify(this.zones.shapes);
      this.tell(text);
    },
    told_refused({ text }) {
      this.asking = false;
      this.tell(text);
    },
    tell(text) {
      this.notice = text;
      clearTimeout(this.silence);
      this.silence = setTimeout(() => (this.notice = ''), 6000);
    },
    take_frame(head, buffer) {
      const rows = rowsOf(buffer, head);
      if (head.kind === PAST) {
        this.asking = false;
        this.world.recall(head, rows);
        if (!this.ground.bounds) this.fit(rows);
        if (this.asked !== null) this.ask_past();
      } else if (this.is_live) {
        const now = performance.now();
        this.world.hear(head, rows, now);
        this.arrivals.push(now);
        this.count = rows.length;
        this.has_come = true;
        if (!this.ground.bounds) this.fit(rows);
      }
      this.touch();
    },
    // Of no known site: show all places where somebody was.
    fit(rows) {
      const { view } = this;
      const [left, low, right, high] = this.fitted || [Infinity, Infinity, -Infinity, -Infinity];
      this.fitted = [
        Math.min(left, ...rows.map(({ x }) => x - 2)), Math.min(low, ...rows.map(({ y }) => y - 2)),
        Math.max(right, ...rows.map(({ x }) => x + 2)),
        Math.max(high, ...rows.map(({ y }) => y + 2)),
      ];
      if (rows.length) view.bounds = this.fitted;
      if (view.whole && rows.length) view.show_all();
    },
    async take_image(head, buffer) {
      const { boxes, blob } = imageOf(buffer, head);
      const { name } = this.ground.cameras[head.camera];
      const canvas = this.$el.querySelector(`canvas[data-camera="${name}"]`);
      if (!canvas) return;
      const bitmap = await createImageBitmap(blob);
      const width = Math.round(canvas.clientWidth * (window.devicePixelRatio || 1)) || 320;
      const scale = width / bitmap.width;
      Object.assign(canvas, { width, height: Math.round(bitmap.height * scale) });
      const context = canvas.getContext('2d', { alpha: false });
      context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
      bitmap.close();
      for (const { left, top, width: wide, height, id, members } of boxes) {
        const [x, y] = [left * scale, top * scale];
        context.strokeStyle = id ? colourOf(id).body : '#dfe5ea';
        context.lineWidth = id && id === this.chosen ? 4 : 2;
        context.strokeRect(x, y, wide * scale, height * scale);
        const text = (id ? String(id) : '') + (members === 1 ? '' : ` ×${members || '?'}`);
        if (!text) continue;
        context.font = '600 11px system-ui, sans-serif';
        context.fillStyle = id ? colourOf(id).label : '#dfe5ea';
        context.fillRect(x - 1, y - 14, context.measureText(text).width + 6, 14);
        context.fillStyle = '#0c0f12';
        context.fillText(text, x + 2, y - 3);
      }
      this.bitmaps[name] = head.time;
    },
    // Events, as text.
    add_events(lines) {
      for (const line of lines) {
        this.number += 1;
        this.events.push(Object.freeze({
          ...line, key: this.number, at: clock_text(line.time), text: this.event_text(line),
          colour: colourOfEvent(line.event),
        }));
      }
      if (this.events.length > MOST_EVENTS) this.events.splice(0, this.events.length - MOST_EVENTS);
    },
    event_text({ event, track, old, new: now, others, zone }) {
      if (event === 'correction') return `${old} is ${now}`;
      if (event === 'feedback_missed') return 'feedback missed';
      if (event === 'occupancy') return `${zone}: ${now} in it (${old} before)`;
      if (event === 'crowded') return `${zone}: crowded by ${now}`;
      const name = (ZONE_WORDS[event] || event.replaceAll('_', ' ')).replace('%', zone);
      const rest = others.length ? ` with ${others.join(', ')}` : '';
      const parted = event === 'split' && old && old !== now ? ` from ${old}` : '';
      return `${track || 'somebody'}: ${name}${rest}${parted}`;
    },
    flash(line) {
      if (NO_FLASH.includes(line.event)) return;
      const row = this.tracks.find(({ id }) => id === line.track);
      const place = line.place || (row && [row.x, row.y]);
      if (!place) return;
      const [began, colour] = [performance.now(), colourOfEvent(line.event)];
      this.flashes.push({ place, began, colour, text: line.event.replaceAll('_', ' ') });
      this.touch();
    },
    open_event(event) {
      if (event.track) this.choose(event.track);
      if (this.past.ended && event.time >= this.past.began && event.time < this.end) {
        this.seek(event.time);
      }
      if (event.place) this.view.centre(...event.place);
      this.touch();
    },
    // Twice a second: what stands in lists.
    look() {
      const now = performance.now();
      this.arrivals = this.arrivals.filter((each) => now - each < 2000);
      this.rate = Math.round(this.arrivals.length / 2);
      this.listed = [...this.tracks].sort((a, b) => a.id - b.id).map((track) => ({
        id: track.id, text: this.track_text(track),
      }));
      const row = this.tracks.find(({ id }) => id === this.chosen);
      this.who = row ? {
        kind: this.kind_text(row), text: this.track_text(row), seen: this.seen_by(row, now).join(' '),
      } : null;
      if (this.follow && row && this.is_live) this.show_who_sees();
      if (!this.is_live && this.time) this.shown_time = this.time;
      else if (this.is_live) this.shown_time = this.end || 0;
    },
    kind_text(row) {
      const kind = CLASSES[row.class] || 'unknown';
      return `${kind === 'unknown' ? '' : `${kind}, `}${STATUS[row.status] || ''}`;
    },
    track_text({ x, y, vx, vy, xx, yy }) {
      const error = Math.sqrt(Math.max(xx + yy, 0));
      const speed = Math.hypot(vx, vy);
      return `${speed.toFixed(1)} m/s · at ${x.toFixed(1)}, ${y.toFixed(1)} ± ${error.toFixed(1)} m`;
    },
    // The cameras that saw somebody a moment ago.
    seen_by({ cameras }, now) {
      this.bits.forEach((name, bit) => {
        if ((cameras >>> bit) & 1) this.seen.set(name, now);
      });
      return this.bits.filter((name) => now - (this.seen.get(name) || -SEEN_MS) < SEEN_MS);
    },
    show_who_sees() {
      const seen = this.seen_by({ cameras: 0 }, performance.now()).slice(0, MOST_PICTURES);
      if (seen.length && String(seen) !== String(this.shown)) {
        this.shown = seen;
        this.ask_pictures();
      }
    },
    choose(id, is_followed = false) {
      this.chosen = id;
      this.seen.clear();
      this.follow = id ? is_followed || this.follow : false;
      this.look();
      this.keep();
      this.touch();
    },
    search() {
      const id = Number(this.wanted);
      if (!Number.isInteger(id) || id < 1) {
        this.tell('An id is a whole number');
      } else if (this.tracks.some((track) => track.id === id)) {
        this.choose(id, true);
      } else if (this.past.ended) {
        this.link.ask({ kind: 'find', track: id, before: this.end + 1 });
      } else {
        this.tell(`Nobody here is called ${id}`);
      }
    },
    colour: (id) => colourOf(id).body,
    camera_colour: (k, { name }) => (name === 'tracker' ? '#dfe5ea'
      : CAMERA_COLOURS[k % CAMERA_COLOURS.length]),
    show(name) {
      this.shown = this.shown.includes(name) ? this.shown.filter((each) => each !== name)
        : [...this.shown, name].slice(-6);
      delete this.bitmaps[name];
      this.ask_pictures();
      this.keep();
    },
    ask_pictures() {
      if (this.ground.live) this.link.ask({ kind: 'show', cameras: [...this.shown] });
    },
    toggle(name) {
      this.layers[name] = !this.layers[name];
      this.keep();
      this.touch();
    },
    // Time.
    go_live() {
      if (!this.ground.live) return;
      if (!this.is_live) this.world.clear();
      Object.assign(this, { is_live: true, playing: false, asked: null });
      this.link.ask({ kind: 'live' });
      this.touch();
    },
    seek(time) {
      if (!time) return;
      if (this.is_live) this.world.clear();
      this.is_live = false;
      this.time = this.shown_time = time;
      this.played = performance.now();
      this.need(time);
      this.touch();
    },
    play() {
      if (this.is_live) this.seek(this.past.began);
      this.playing = !this.playing;
      if (this.playing && this.time >= this.end - 0.1) this.seek(this.past.began);
      this.played = performance.now();
      this.touch();
    },
    // Ask for what is to be shown at a time, unless it is known.
    need(time) {
      const { world } = this;
      const ahead = Math.min(time + (this.playing ? 2 * this.speed : 0), this.end);
      const knows = world.from !== null && world.from <= Math.max(time - TRAIL_S, this.past.began)
        && ahead < world.until;
      if (knows) return;
      this.asked = time;
      if (!this.asking) this.ask_past();
    },
    ask_past() {
      this.asking = true;
      this.link.ask({ kind: 'at', time: this.asked });
      this.asked = null;
    },
    // Zones.
    draw(kind) {
      if (this.drawing === kind) this.tool.cancel();
      else this.tool.begin(kind);
      this.layers.zones = true;
      this.touch();
    },
    discard() {
      this.zones.chosen = -1;
      this.zones.shapes = JSON.parse(this.saved);
      this.touch();
    },
    save() {
      this.link.ask({ kind: 'draw', shapes: this.zones.shapes });
    },
    // The mouse, or fingers.
    at(event) {
      const box = this.$refs.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    },
    wheel(event) {
      this.zoom(Math.exp(-Math.max(-300, Math.min(300, event.deltaY)) * 0.0015), this.at(event));
    },
    zoom(factor, at = [this.view.width / 2, this.view.height / 2]) {
      this.view.zoom(factor, at);
      this.touch();
    },
    show_all() {
      this.follow = false;
      this.view.show_all();
      this.touch();
    },
    press(event) {
      if (event.button > 1) return;
      const at = this.at(event);
      this.$refs.canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, { at, from: at, moved: false });
      const edits = this.tab === 'zones' && this.ground.editable && this.pointers.size === 1;
      this.edits = edits && event.button === 0 && this.tool.press(this.view, ...at);
      this.touch();
    },
    glide(event) {
      const at = this.at(event);
      const held = this.pointers.get(event.pointerId);
      if (this.edits || this.zones.drawing) {
        this.tool.glide(this.view, ...at);
        this.touch();
      }
      if (!held) return;
      const before = held.at;
      held.at = at;
      held.moved ||= Math.hypot(at[0] - held.from[0], at[1] - held.from[1]) > STILL;
      const is_panning = !this.edits || this.zones.drawing;
      if (!held.moved || !is_panning) return;
      this.moving = true;
      this.follow = false;
      const others = [...this.pointers.values()].filter((each) => each !== held);
      const view = this.view;
      if (others.length) {
        const other = others[0].at;
        const [now, was] = [at, before].map(([x, y]) => Math.hypot(x - other[0], y - other[1]));
        view.zoom(now / Math.max(was, 1), other);
      } else {
        view.centre(
          view.x - (at[0] - before[0]) / view.scale, view.y + (at[1] - before[1]) / view.scale,
        );
      }
      this.touch();
    },
    release(event) {
      const held = this.pointers.get(event.pointerId);
      this.pointers.delete(event.pointerId);
      this.moving = false;
      if (!held) return;
      const is_click = !held.moved && event.button === 0;
      if (this.edits) this.tool.release(this.view, ...held.at, is_click);
      else if (is_click) this.choose(this.met(...held.at));
      this.edits = false;
      this.touch();
    },
    met(px, py) {
      let [nearest, least] = [0, REACH];
      for (const track of this.painter.drawn) {
        const away = Math.hypot(track.px - px, track.py - py);
        if (away < least + track.radius / 2) [nearest, least] = [track.id, away];
      }
      return nearest;
    },
    key(event) {
      if (event.key === 'Enter') this.tool.finish();
      else if (event.key === 'Escape') this.tool.cancel();
      else if (event.key === '+' || event.key === '-') this.zoom(event.key === '+' ? 1.5 : 1 / 1.5);
      else return;
      this.touch();
    },
    // Drawing.
    draw_frame(now) {
      const { world } = this;
      const still_moving = this.is_live ? world.is_moving(now) : this.playing;
      this.flashes = this.flashes.filter((flash) => is_flashing(flash, now));
      if (!this.dirty && !still_moving && !this.flashes.length) return;
      if (now - this.last < FRAME_MS) return;
      this.last = now;
      this.dirty = false;
      if (this.is_live) this.time = world.clock(now);
      else this.advance(now);
      this.tracks = this.time === null || this.time === undefined ? [] : world.at(this.time);
      const row = this.follow && this.tracks.find(({ id }) => id === this.chosen);
      if (row) this.view.centre(row.x, row.y);
      this.painter.paint({
        ground: { lines: [], area: [], ...this.ground }, layers: this.layers, levels: this.levels,
        tracks: this.tracks, world, time: this.time, chosen: this.chosen, flashes: this.flashes,
        zones: this.tool, still: this.still,
      }, now);
    },
    advance(now) {
      if (!this.playing) return;
      const { world } = this;
      const step = (Math.min(now - this.played, 200) / 1000) * this.speed;
      this.played = now;
      if (world.from === null || this.time + step >= world.until) {
        this.need(this.time + step);
        return; // wait for it
      }
      const before = this.time;
      this.time = Math.min(this.time + step, this.end);
      this.need(this.time);
      if (this.time >= this.end && !this.ground.live) this.playing = false;
      for (const event of this.events) {
        if (event.time > before && event.time <= this.time) this.flash(event);
      }
    },
    // A window that is loaded again looks as before.
    keep() {
      const { chosen, follow, layers, shown } = this;
      sessionStorage.setItem(KEPT, JSON.stringify({ chosen, follow, layers, shown }));
    },
    recall_view() {
      try {
        const { chosen, follow, layers, shown } = JSON.parse(sessionStorage.getItem(KEPT) || '{}');
        Object.assign(this, { chosen: chosen || 0, follow: Boolean(follow), shown: shown || [] });
        Object.assign(this.layers, layers);
      } catch {
        sessionStorage.removeItem(KEPT);
      }
    },
  },
};

const clock_text = (time) => new Date(time * 1000).toTimeString().slice(0, 8);

function length_text(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
}
