// A drawing to click on, drag in, zoom and pan. Coordinates are the drawing's own.
const REACH = 11; // how near to a mark a click meets it, screen pixels
const STILL = 4; // what the mouse may move during a click, screen pixels
const FINEST = 1 / 40; // drawing units a screen pixel when zoomed in all the way

export default {
  template: `
    <div class="board" ref="box" tabindex="0">
      <svg ref="svg" :viewBox="viewBox" preserveAspectRatio="none"
           :class="{ placing, dragging: held && held.moved }"
           @wheel.prevent="zoom" @pointerdown="press" @pointermove="glide"
           @pointerup="release" @pointercancel="held = null" @pointerleave="at = null">
        <image v-if="image" :href="image" :x="frame[0]" :y="frame[1]" :width="frame[2]"
               :height="frame[3]" preserveAspectRatio="none"
               :style="{ imageRendering: unit === 'm' || scale < 0.5 ? 'pixelated' : 'auto' }" />
        <polyline v-for="line in drawing.lines" :points="line.points.join(' ')" :class="line.kind"
                  vector-effect="non-scaling-stroke" />
        <g v-for="arrow in drawing.arrows" :class="arrow.kind">
          <line :x1="arrow.points[0][0]" :y1="arrow.points[0][1]" :x2="arrow.points[1][0]"
                :y2="arrow.points[1][1]" vector-effect="non-scaling-stroke" />
          <polygon points="0,0 -8,3.5 -8,-3.5" :transform="head(arrow.points)" />
        </g>
        <g v-for="mark in marks" :key="mark.name" :class="['mark', mark.kind]"
           :data-name="mark.name" :transform="at_screen(mark)">
          <circle r="6.5" class="ring" />
          <circle r="1.3" class="dot" />
          <text v-if="labelled(mark)" x="9" y="-7">{{ mark.name }}</text>
        </g>
      </svg>
      <div class="readout">{{ readout }}</div>
    </div>`,
  props: {
    extent: Array,
    frame: Array,
    origin: Array, // what is added to the drawing's coordinates where they are told
    image: String,
    unit: String,
    placing: Boolean,
    drawing: { type: Object, default: () => ({ lines: [], arrows: [], marks: [] }) },
  },
  data: () => ({ x: 0, y: 0, scale: 1, width: 1, height: 1, held: null, at: null, whole: true }),
  computed: {
    viewBox() {
      return [this.x, this.y, this.width * this.scale, this.height * this.scale].join(' ');
    },
    marks() {
      const held = this.held;
      if (!held || !held.moved || !held.mark) return this.drawing.marks;
      return this.drawing.marks.map((mark) =>
        mark.name === held.mark.name ? { ...mark, x: held.x, y: held.y } : mark,
      );
    },
    readout() {
      if (!this.at) return '';
      const [x, down] = this.at.map((along, axis) => along + this.origin[axis]);
      const y = this.unit === 'm' ? -down : down;
      const digits = this.scale < 0.2 ? 2 : 1;
      return `${x.toFixed(digits)}, ${y.toFixed(digits)} ${this.unit}`;
    },
  },
  watch: {
    extent(now, before) {
      if (now.join() !== before.join()) this.show_all();
    },
    image() {
      if (this.unit === 'px') this.show_all();
    },
    drawing() {
      if (this.held && this.held.done) this.held = null;
    },
  },
  mounted() {
    this.observer = new ResizeObserver(() => {
      this.width = Math.max(this.$refs.box.clientWidth, 1);
      this.height = Math.max(this.$refs.box.clientHeight, 1);
      if (this.whole) this.show_all();
    });
    this.observer.observe(this.$refs.box);
  },
  beforeUnmount() {
    this.observer.disconnect();
  },
  methods: {
    widest() {
      return Math.max(this.extent[2] / this.width, this.extent[3] / this.height);
    },
    show_all() {
      this.scale = this.widest();
      this.x = this.extent[0] + (this.extent[2] - this.width * this.scale) / 2;
      this.y = this.extent[1] + (this.extent[3] - this.height * this.scale) / 2;
      this.whole = true;
    },
    place_of(event) {
      const box = this.$refs.svg.getBoundingClientRect();
      return [
        this.x + (event.clientX - box.left) * this.scale,
        this.y + (event.clientY - box.top) * this.scale,
      ];
    },
    zoom(event) {
      const [x, y] = this.place_of(event);
      const factor = Math.exp(Math.max(-300, Math.min(300, event.deltaY)) * 0.0015);
      const finest = this.unit === 'px' ? FINEST : this.widest() / 50;
      const scale = Math.max(finest, Math.min(this.widest(), this.scale * factor));
      if (scale === this.widest()) return this.show_all();
      this.x = x - ((x - this.x) * scale) / this.scale;
      this.y = y - ((y - this.y) * scale) / this.scale;
      this.scale = scale;
      this.whole = false;
    },
    met(x, y) {
      let nearest = null;
      let least = REACH * this.scale;
      for (const mark of this.drawing.marks) {
        const away = Math.hypot(mark.x - x, mark.y - y);
        if (away <= least) [nearest, least] = [mark, away];
      }
      return nearest;
    },
    press(event) {
      if (event.button > 1) return;
      this.$refs.box.focus({ preventScroll: true });
      this.$refs.svg.setPointerCapture(event.pointerId);
      const [x, y] = this.place_of(event);
      const mark = event.button === 0 ? this.met(x, y) : null;
      const movable = mark && mark.movable ? mark : null;
      this.held = {
        mark: movable, met: mark, x, y, moved: false, done: false, button: event.button,
        grip: movable ? [mark.x - x, mark.y - y] : [x, y], from: [event.clientX, event.clientY],
      };
    },
    glide(event) {
      const [x, y] = this.place_of(event);
      this.at = [x, y];
      const held = this.held;
      if (!held || held.done) return;
      const far = Math.hypot(event.clientX - held.from[0], event.clientY - held.from[1]);
      if (far > STILL) held.moved = true;
      if (!held.moved) return;
      if (held.mark) {
        [held.x, held.y] = [x + held.grip[0], y + held.grip[1]];
      } else {
        this.x += held.grip[0] - x;
        this.y += held.grip[1] - y;
        this.whole = false;
      }
    },
    release() {
      const held = this.held;
      if (!held || held.done) return;
      if (held.moved && held.mark) {
        held.done = true;
        this.$emit('moved', { name: held.mark.name, x: held.x, y: held.y });
        return;
      }
      this.held = null;
      if (held.moved || held.button) return;
      if (held.met && !this.placing) this.$emit('picked', { name: held.met.name });
      else this.$emit('placed', { x: held.x, y: held.y });
    },
    at_screen(mark) {
      return `translate(${mark.x} ${mark.y}) scale(${this.scale})`;
    },
    labelled(mark) {
      if (mark.kind === 'corner') return false;
      if (!['free', 'expected'].includes(mark.kind)) return true;
      return this.drawing.marks.length < 45 || this.scale < this.widest() / 2;
    },
    head([from, to]) {
      const angle = (Math.atan2(to[1] - from[1], to[0] - from[0]) * 180) / Math.PI;
      const long = Math.hypot(to[0] - from[0], to[1] - from[1]) / this.scale;
      const size = this.scale * Math.min(1, long / 12);
      return `translate(${to[0]} ${to[1]}) rotate(${angle}) scale(${size})`;
    },
  },
};
