// The hammer in its hole: piston and bit to scale with the stress in them, casing and chuck around
// them (where the scene has a casing, at their computed place), and below it the stress along both bodies.

/** How much wider than the bit the hole is where no diameter is given: alone, and with room for a chuck. */
const CLEARANCE = 1.3, CHUCK_CLEARANCE = 1.6;
/** Part of the picture's height from which the stress is drawn. */
const STRIP = 0.64;
/** Length of the bit's collar, drawn and not computed, over the length of the chuck. */
const COLLAR = 0.12;

/** Draws moments of a cycle. */
class Drawing {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
  }

  /** Takes a cycle of the scene, what its bodies measure, the gap at the start, the hole's
   * diameter (0: not given), and how far the bit can hang out of the chuck (0: there is no casing). */
  show(cycle, bodies, gap, diameter, travel) {
    Object.assign(this, { cycle, bodies, gap, travel });
    const largest = (lists) => {
      let most = 0;
      for (const list of lists) for (const value of list) most = Math.max(most, Math.abs(value));
      return most;
    };
    this.limit = Math.max(1e6, ...cycle.stress.map(largest));
    const start = Math.max(0, cycle.time.findIndex((time) => time >= cycle.impact));
    this.base = cycle.hole_depth[start];
    const [piston, bit] = bodies;
    const radius = (area) => Math.sqrt(area / Math.PI);
    this.radii = bodies.map(({ areas }) => areas.map(radius));
    const bore = 1.08 * Math.max(...this.radii[0]);
    const shank = radius(bit.areas[0]);
    const hole = Math.max(diameter / 2, (travel ? CHUCK_CLEARANCE : CLEARANCE) * Math.max(bore, ...this.radii[1]));
    this.hole = { bore, shank, radius: hole, casing: bore + 0.6 * (hole - bore) };
    // The head is what is wider than the shank; a uniform bit gets a chuck over its upper half.
    const head = this.radii[1].findIndex((r) => r > 1.05 * shank);
    this.chuck = head > 0 ? bit.ends[head] : 0.55 * bit.length;
    this.flange = head > 0 ? 0 : 0.05 * bit.length;
    this.chuckLimit = Math.max(1, largest([cycle.chuck_force]));
    const flown = Math.min(...cycle.piston_position) - this.base - this.gap - piston.length;
    // A piston that idles may fly far: it leaves the picture.
    const highest = cycle.lifted ? Math.max(flown, -2 * piston.length - travel) : flown;
    this.span = [highest - 0.06 * (bit.length - highest), bit.length + 0.12 * (bit.length - highest)];
  }

  draw(index) {
    const { pen, cycle, bodies, span: [low, high] } = this;
    const [width, height] = fit(this.canvas);
    this.colours = stressColours();
    pen.clearRect(0, 0, width, height);
    const [left, right] = [50, width - 8];
    // One scale along and across, if the hole then fits.
    const scale = (right - left) / (high - low);
    const middle = 0.31 * height;
    const across = Math.min(scale, (0.24 * height) / this.hole.radius);
    const x = (place) => Math.max(left, left + (place - low) * scale);
    const y = (r) => r * across;
    const tops = [
      cycle.piston_position[index] - this.gap - this.base - bodies[0].length,
      cycle.bit_position[index] - this.base,
    ];
    const bottom = cycle.hole_depth[index] - this.base + bodies[1].length;
    this.rock({ left, right, middle, y, surface: x(bottom), edge: 0.29 * height });
    const shift = this.travel ? cycle.casing_position[index] - this.base : 0;
    const chuck = this.casing(x, y, middle, left, shift);
    const strip = { top: STRIP * height, bottom: height - 20, left, right };
    this.axis(strip);
    ["piston", "bit"].forEach((name, body) => {
      const stress = cycle.stress[body][index];
      const edges = Array.from(bodies[body].ends, (end) => x(tops[body] + end));
      this.bar(edges, stress, middle, this.radii[body].map(y), palette[name]);
      this.curve(edges, stress, strip, palette[name]);
    });
    this.inserts(x(tops[1] + bodies[1].length), middle, y(this.radii[1].at(-1)));
    if (this.travel) this.tie(x, y, middle, tops[1], chuck, cycle.chuck_force[index]);
    this.words(x, y, tops, middle, right, shift);
  }

  /** Rock around the hole and below it. */
  rock({ left, right, middle, y, surface, edge }) {
    const { pen } = this, wall = y(this.hole.radius);
    const around = new Path2D();
    around.moveTo(left, middle - edge);
    around.lineTo(right, middle - edge);
    around.lineTo(right, middle + edge);
    around.lineTo(left, middle + edge);
    around.lineTo(left, middle + wall);
    around.lineTo(surface, middle + wall);
    around.lineTo(surface, middle - wall);
    around.lineTo(left, middle - wall);
    around.closePath();
    pen.fillStyle = palette.ground;
    pen.fill(around);
    pen.save();
    pen.clip(around);
    pen.strokeStyle = palette.rock;
    pen.lineWidth = 0.5;
    pen.beginPath();
    for (let at = left - 2 * edge; at < right; at += 11) {
      pen.moveTo(at, middle + edge);
      pen.lineTo(at + 2 * edge, middle - edge);
    }
    pen.stroke();
    pen.restore();
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(left, middle - wall);
    pen.lineTo(surface, middle - wall);
    pen.lineTo(surface, middle + wall);
    pen.lineTo(left, middle + wall);
    pen.strokeStyle = palette.rock;
    pen.stroke();
  }

  /** The casing around the piston and the chuck that guides the bit, both cut open; `shift` is their
   * way down. Returns where the retaining ring and the lower end of the chuck are drawn. */
  casing(x, y, middle, left, shift) {
    const { pen, hole, travel, chuck } = this, end = x(chuck + shift) - (travel ? 0 : 4);
    // The bit's collar has its travel between the upper end of this chamber and the ring.
    const top = x(shift), ring = travel ? Math.min(x(shift + COLLAR * chuck + travel), end - 12) : top + 0.15 * (end - top);
    const chamber = travel ? this.collar() * 1.03 : hole.bore;
    pen.fillStyle = palette.casing;
    for (const side of [-1, 1]) {
      const at = (r) => middle + side * y(r);
      pen.beginPath();
      pen.moveTo(left, at(hole.casing));
      pen.lineTo(end, at(hole.casing));
      pen.lineTo(end, at(1.06 * hole.shank));
      pen.lineTo(ring, at(1.06 * hole.shank));
      pen.lineTo(ring, at(chamber));
      pen.lineTo(top - 2, at(chamber));
      pen.lineTo(top - 2, at(hole.bore));
      pen.lineTo(left, at(hole.bore));
      pen.closePath();
      pen.fill();
    }
    return { ring, end };
  }

  /** Radius of the collar by which the ring holds the bit. */
  collar() {
    const { shank, bore, casing } = this.hole;
    return Math.max(bore, 0.5 * (1.06 * shank + casing));
  }

  /** What ties bit and casing: the bit's collar, the retaining ring, and the shoulder on the chuck's
   * lower end. Whichever bears is coloured by its force, with an arrow that shows where it pushes the bit. */
  tie(x, y, middle, bit, { ring, end }, force) {
    const { pen, hole, chuck, flange } = this, part = force / this.chuckLimit;
    const [collar, shoulder] = [this.collar(), 0.5 * (hole.shank + hole.casing)];
    const block = (from, to, inner, outer, fill) => {
      for (const side of [-1, 1]) {
        const [low, high] = [inner, outer].map((r) => middle + side * y(r));
        pen.fillStyle = fill;
        pen.fillRect(from, Math.min(low, high), to - from, Math.abs(high - low));
        pen.strokeStyle = palette.bit;
        pen.lineWidth = 1.5;
        pen.strokeRect(from, Math.min(low, high), to - from, Math.abs(high - low));
      }
    };
    const pressed = (share) => `rgb(${this.colours[shade(-Math.max(0, share))]})`;
    block(x(bit), x(bit + COLLAR * chuck), hole.shank, collar, palette.steel);
    if (flange) block(x(bit + chuck), x(bit + chuck + flange), hole.shank, shoulder, palette.steel);
    block(ring, ring + 7, 1.06 * hole.shank, collar, pressed(-part));
    block(end - 7, end, 1.06 * hole.shank, hole.casing, pressed(part));
    const from = part > 0 ? end : ring, way = Math.sign(part) * (8 + 34 * Math.abs(part));
    if (Math.abs(part) > 1e-3) [-1, 1].forEach((side) => this.arrow(from, middle + side * y(shoulder), way));
  }

  /** An arrow along the axis. */
  arrow(from, level, way) {
    const { pen } = this, point = from + way, back = point - 7 * Math.sign(way);
    for (const [style, wide] of [[palette.paper, 5], [palette.compression, 2.5]]) {
      Object.assign(pen, { strokeStyle: style, lineWidth: wide });
      pen.beginPath();
      pen.moveTo(from, level);
      pen.lineTo(point, level);
      pen.moveTo(back, level - 4);
      pen.lineTo(point, level);
      pen.lineTo(back, level + 4);
      pen.stroke();
    }
  }

  bar(edges, stress, middle, heights, colour) {
    const { pen } = this;
    stress.forEach((value, i) => {
      pen.fillStyle = `rgb(${this.colours[shade(value / this.limit)]})`;
      // A hair wider: no seams between elements.
      pen.fillRect(edges[i], middle - heights[i], edges[i + 1] - edges[i] + 0.5, 2 * heights[i]);
    });
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.beginPath();
    for (const side of [-1, 1]) {
      pen.moveTo(edges[0], middle);
      heights.forEach((height, i) => {
        pen.lineTo(edges[i], middle + side * height);
        pen.lineTo(edges[i + 1], middle + side * height);
      });
      pen.lineTo(edges.at(-1), middle);
    }
    pen.stroke();
  }

  /** Round tips on the bit's face. */
  inserts(face, middle, radius) {
    const { pen } = this, count = 5, size = radius / count;
    pen.fillStyle = palette.ink;
    for (let i = 0; i < count; i++) {
      const at = middle + (2 * i - count + 1) * size;
      pen.beginPath();
      pen.ellipse(face - 0.3 * size, at, 0.45 * size, 0.55 * size, 0, -Math.PI / 2, Math.PI / 2);
      pen.fill();
    }
  }

  axis({ top, bottom, left, right }) {
    const { pen } = this;
    const most = Number((0.8 * this.limit * 1e-6).toPrecision(1));
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of [-most, 0, most]) {
      const y = this.level(value * 1e6, top, bottom);
      pen.strokeStyle = value === 0 ? palette.muted : palette.grid;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(right, y);
      pen.stroke();
      pen.fillStyle = palette.ink;
      pen.fillText(String(value).replace("-", "−"), left - 5, y);
    }
    pen.textAlign = "left";
    const room = right - left;
    pen.fillText(say(room < 320 ? "stress_short" : "stress_long"), left, bottom + 11);
  }

  level(stress, top, bottom) {
    return 0.5 * (top + bottom) - (stress / this.limit) * 0.48 * (bottom - top);
  }

  curve(edges, stress, { top, bottom }, colour) {
    const { pen } = this;
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.beginPath();
    stress.forEach((value, i) => {
      pen.lineTo(0.5 * (edges[i] + edges[i + 1]), this.level(value, top, bottom));
    });
    pen.stroke();
  }

  /** Names in the free space: above the hole and inside the bodies. */
  words(x, y, tops, middle, right, shift) {
    const { pen } = this;
    pen.font = "600 13px system-ui, sans-serif";
    pen.textBaseline = "middle";
    const word = (text, at, height, align = "center") => {
      pen.textAlign = align;
      pen.lineWidth = 4;
      pen.strokeStyle = palette.paper;
      pen.strokeText(text, at, height);
      pen.fillStyle = palette.ink;
      pen.fillText(text, at, height);
    };
    const above = middle - y(this.hole.radius) - 10;
    word(say("casing"), x(this.span[0]) + 6, above, "left");
    word(say("chuck"), x(0.6 * this.chuck + shift), above);
    word(say("piston"), x(tops[0] + 0.5 * this.bodies[0].length), middle);
    word(say("bit"), x(tops[1] + 0.5 * this.bodies[1].length), middle);
    word(say("rock"), right - 5, middle + y(this.hole.radius) + 12, "right");
  }
}

/** One insert at the hole's bottom, millimetres wide: what a blow gains, and the blows before. */
class Lens {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
  }

  /** Takes a cycle and the depth of the hole at its impact. */
  show(cycle, base, gain) {
    [this.cycle, this.base, this.gain] = [cycle, base, gain];
    let reached = -Infinity;
    /** The deepest place of the tip so far, sample by sample. */
    this.crater = cycle.bit_tip_position.map((tip) => (reached = Math.max(reached, tip - base)));
    const deepest = Math.max(1e-5, reached);
    this.span = [-1.6 * Math.max(deepest, 2 * gain), 1.5 * deepest];
  }

  draw(index) {
    const { pen, cycle, span: [low, high] } = this;
    const [width, height] = fit(this.canvas);
    const y = (place) => ((place - low) / (high - low)) * (height - 22);
    const tip = y(cycle.bit_tip_position[index] - this.base), crater = y(Math.max(0, this.crater[index]));
    const hole = y(cycle.hole_depth[index] - this.base), middle = 0.6 * width;
    // The marks to the left of the hole have 56 pixels at least.
    const round = Math.min(0.26 * width, 0.5 * height, (middle - 56) / 1.25);
    pen.fillStyle = palette.paper;
    pen.fillRect(0, 0, width, height);
    pen.fillStyle = palette.ground;
    pen.fillRect(0, 0, width, height - 22);
    // The hole: as far down as blows have broken it, at most the crater of this one.
    pen.fillStyle = palette.paper;
    pen.fillRect(middle - 1.25 * round, 0, 2.5 * round, Math.max(hole, y(0)));
    this.cracks(middle, crater, round);
    pen.fillStyle = palette.paper;
    this.nose(middle, crater, round);
    pen.fillStyle = palette.casing;
    this.nose(middle, tip, 0.97 * round);
    this.marks(y, middle - 1.25 * round, hole);
    this.scale(width, height, y);
  }

  /** A round nose from above down to a place. */
  nose(middle, tip, round) {
    const { pen } = this;
    pen.beginPath();
    pen.moveTo(middle - round, -5);
    pen.lineTo(middle - round, tip - 0.7 * round);
    pen.quadraticCurveTo(middle - 0.8 * round, tip, middle, tip);
    pen.quadraticCurveTo(middle + 0.8 * round, tip, middle + round, tip - 0.7 * round);
    pen.lineTo(middle + round, -5);
    pen.closePath();
    pen.fill();
  }

  /** Broken rock under the deepest place of the tip: drawn, not computed. */
  cracks(middle, crater, round) {
    const { pen } = this, deep = crater + 0.35 * round;
    pen.strokeStyle = palette.rock;
    pen.lineWidth = 1.2;
    pen.beginPath();
    for (const turn of [-1.15, -0.6, -0.1, 0.45, 1.05]) {
      const side = Math.sin(turn), down = Math.cos(turn);
      pen.moveTo(middle + 0.5 * round * side, crater - 0.2 * round + 0.2 * round * down);
      pen.lineTo(middle + 0.8 * round * side, crater - 0.2 * round + 0.45 * round * down);
      pen.lineTo(middle + 1.1 * round * side, deep - 0.5 * round + 0.6 * round * down);
    }
    pen.stroke();
  }

  /** The hole's bottom now, and after each blow before. */
  marks(y, edge, hole) {
    const { pen } = this;
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.strokeStyle = palette.rock;
    pen.fillStyle = palette.ink;
    pen.lineWidth = 2;
    let free = Infinity;
    for (const [text, at] of [[say("now"), hole], ...[0, 1, 2, 3].map((k) => [k ? `−${k}` : say("before"), y(-k * this.gain)])]) {
      if (at < 8 || free - at < 13) continue;
      free = at;
      pen.beginPath();
      pen.moveTo(edge - 14, at);
      pen.lineTo(edge, at);
      pen.stroke();
      pen.fillText(text, edge - 17, at);
    }
  }

  scale(width, height, y) {
    const { pen } = this, unit = Number((0.4 * this.span[1]).toPrecision(1));
    const long = y(unit) - y(0);
    pen.fillStyle = palette.ink;
    pen.fillRect(width - 9, 6, 3, long);
    pen.textAlign = "right";
    pen.fillText(`${digits(1e3 * unit, 2)} mm`, width - 13, 6 + Math.max(6, 0.5 * long));
    pen.textAlign = "left";
    pen.fillText(say("lens_caption"), 4, height - 10);
  }
}

/** Which sample is shown when: waves at the pace asked for, flights fast-forwarded if wanted. */
class Player {
  constructor() {
    this.index = 0;
    this.playing = true;
    /** Seconds of the hammer for one of the viewer. */
    this.timeScale = 2e-4;
    this.hurry = true;
    this.rest = 0;
  }

  show(cycle) {
    this.cycle = cycle;
    this.index = 0;
  }

  /** Shows the first sample at a time after the impact, s, or later. */
  goTo(time) {
    const after = this.cycle.time.findIndex((t) => t >= this.cycle.impact + time);
    this.index = after < 0 ? this.cycle.time.length - 1 : after;
  }

  /** Moves on by so many of the viewer's seconds. */
  advance(seconds) {
    const { time } = this.cycle;
    this.rest += seconds;
    for (;;) {
      const next = this.index + 1;
      if (next >= time.length) {
        this.index = 0;
        return;
      }
      const step = time[next] - time[this.index];
      // Long steps are flights: they pass as many times faster as they are longer.
      const factor = this.hurry ? Math.max(1, step / 2e-6) ** 0.9 : 1;
      const takes = step / (this.timeScale * factor);
      if (takes > this.rest) return;
      this.rest -= takes;
      this.index = next;
    }
  }
}
