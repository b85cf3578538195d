// The hammer in its hole, cut open along its axis, which points down: drill string, casing with its two
// chambers, piston, chuck, bit with its head, rock. Piston and bit are coloured by the stress in them.

/** How much wider than the bit the hole is drawn at least: alone, and with room for a chuck. */
const CLEARANCE = 1.3, CHUCK_CLEARANCE = 1.6;
/** The bit's collar, drawn and not computed: its length over that of the chuck. */
const COLLAR = 0.12;
/** The head of a bit of one section, drawn and not computed: its part of the bit. */
const HEAD = 0.3;
/** So many times wider than long are things drawn at most. */
const STRETCH = 2.4;
/** A drill string between piston and bit, drawn as so many times the bit's length. */
const STRING = 1.6;

/** Draws moments of a cycle; with `curve`, the stress along both bodies beside them. */
class Picture extends Drawing {
  constructor(canvas, { curve = false } = {}) {
    super(canvas.getContext("2d"));
    Object.assign(this, { canvas, curve });
  }

  /** Takes a cycle, what its bodies measure, and of the scene: the gap at the start, the hole's
   * diameter, how far the bit can hang out of the chuck (0: there is no casing), rods between piston
   * and bit. `scale`: stress and pressure with the full colour, Pa, and the piston's highest rise, m, where several
   * cycles are to be compared. */
  show(cycle, bodies, { gap, diameter, travel, rods = 0, scale = {} }) {
    Object.assign(this, { cycle, bodies, gap, travel, rods });
    this.limit = scale.limit ?? Math.max(1e6, ...cycle.stress.map(largest));
    const start = Math.max(0, cycle.time.findIndex((time) => time >= cycle.impact));
    this.base = cycle.tip_depth[start];
    const [piston, bit] = bodies, radius = (area) => Math.sqrt(area / Math.PI);
    this.radii = bodies.map(({ areas }) => areas.map(radius));
    const bore = 1.08 * Math.max(...this.radii[0]), shank = this.radii[1][0];
    const hole = Math.max(diameter / 2, (travel ? CHUCK_CLEARANCE : CLEARANCE) * Math.max(bore, ...this.radii[1]));
    const casing = bore + 0.55 * (hole - bore);
    // The head is the part wider than the shank. A bit of one section gets a head, and a chuck around the rest.
    const head = this.radii[1].findIndex((r) => r > 1.05 * shank);
    this.chuck = head > 0 ? bit.ends[head] : (1 - HEAD) * bit.length;
    this.head = head > 0 ? 0 : Math.max(shank, 0.93 * hole);
    this.hole = { bore, shank, radius: hole, casing };
    this.string = rods ? STRING * bit.length : 0;
    this.pushed = Math.max(1, largest([cycle.applied_drive_force]));
    this.pressed = scale.pressed ?? Math.max(1, largest([cycle.drive_chamber_pressure, cycle.return_chamber_pressure]));
    this.chuckLimit = Math.max(1, largest([cycle.chuck_force]));
    const flown = (scale.flown
        ? gap - scale.flown : Math.min(...cycle.piston_position) - this.base) - gap - piston.length - this.string;
    const long = bit.length - flown;
    this.span = [flown - 0.16 * long, bit.length + 0.1 * long];
  }

  /** Where a place on the axis is drawn, in pixels from the top. */
  place(metres) {
    const [low, high] = this.span;
    return ((metres - low) / (high - low)) * this.height;
  }

  /** Upper ends of piston and bit at a sample, m below the bit's upper end at rest. */
  tops(index) {
    const { cycle, bodies, gap, base, string } = this;
    return [cycle.piston_position[index] - gap - base - bodies[0].length - string, cycle.bit_position[index] - base];
  }

  /** Draws a sample; with `sound`, how far down the bit sound has come, m, as a dashed line across it. */
  draw(index, sound = null) {
    const { pen, cycle, bodies, hole } = this;
    const [width, height] = fit(this.canvas);
    this.height = height;
    this.colours = stressColours();
    pen.clearRect(0, 0, width, height);
    const room = this.curve ? 0.62 * width : width;
    // Leaves room for a word beside the hole, even on a phone.
    this.middle = 0.5 * (room - Math.max(0.2 * room, 92));
    const widest = Math.min(0.3 * room, this.middle - 8) / hole.radius;
    const across = Math.min(STRETCH * (height / (this.span[1] - this.span[0])), widest);
    this.x = (radius) => radius * across;
    const y = (metres) => this.place(metres), tops = this.tops(index);
    const bottom = y(cycle.tip_depth[index] - this.base + bodies[1].length);
    this.rock(room, height, bottom);
    const shift = this.travel ? cycle.casing_position[index] - this.base : 0;
    const chuck = this.casing(y, shift);
    this.chambers(y, tops, chuck.top, index);
    if (this.rods) this.rodsBetween(y, shift);
    BODIES.forEach((_, body) => this.body(body, tops[body], cycle.stress[body][index], y));
    this.inserts(y(tops[1] + bodies[1].length));
    if (this.travel) this.tie(y, tops[1], chuck, cycle.chuck_force[index]);
    this.words(room, y, tops, bottom, index);
    if (sound !== null && sound < bodies[1].length) {
      const level = y(tops[1] + sound), wide = this.x(hole.radius);
      this.line([[this.middle - wide, level], [this.middle + wide, level]], palette.ink, 1.5, [5, 4]);
    }
    this.stretched(across / (height / (this.span[1] - this.span[0])), height);
    if (this.curve) this.stressCurve([room + 14, width - 10], y, tops, index);
  }

  /** Says that things are drawn wider than they are long. */
  stretched(times, height) {
    Object.assign(this.pen, { font: "11px system-ui, sans-serif", textAlign: "left", textBaseline: "bottom" });
    this.edged(say("stretched", { times: digits(times, 2) }), 6, height - 4);
  }

  /** A filled ring about the axis, seen cut: both sides. */
  ring(top, bottom, inner, outer, fill, edge = null) {
    const { pen, middle } = this;
    pen.fillStyle = fill;
    for (const side of [-1, 1]) {
      const [from, to] = [inner, outer].map((r) => middle + side * this.x(r));
      pen.fillRect(Math.min(from, to), top, Math.abs(to - from), bottom - top);
      if (!edge) continue;
      Object.assign(pen, { strokeStyle: edge, lineWidth: 1.5 });
      pen.strokeRect(Math.min(from, to), top, Math.abs(to - from), bottom - top);
    }
  }

  /** Rock around the hole and below it. */
  rock(room, height, bottom) {
    const { pen, middle } = this, wall = this.x(this.hole.radius);
    pen.beginPath();
    pen.rect(0, 0, middle - wall, height);
    pen.rect(middle + wall, 0, room - middle - wall, height);
    pen.rect(middle - wall, bottom, 2 * wall, height - bottom);
    pen.fillStyle = palette.ground;
    pen.fill();
    pen.save();
    pen.clip();
    // Grains at random but fixed places.
    Object.assign(pen, { fillStyle: palette.rock, globalAlpha: 0.4 });
    pen.beginPath();
    for (let i = 0, at = 0.5; i < 260; i++) {
      at = (at * 997.13 + 0.371) % 1;
      const across = at * room;
      at = (at * 991.37 + 0.713) % 1;
      pen.rect(across, at * height, 1.5 + 2.5 * ((at * 7) % 1), 1.5);
    }
    pen.fill();
    pen.restore();
    this.line([[middle - wall, 0], [middle - wall, bottom], [middle + wall, bottom], [middle + wall, 0]], palette.rock,
        2);
  }

  /** Drill string, casing and chuck; `shift` is their way down. Returns where the casing's room ends at
   * the top, and where the retaining ring and the lower end of the chuck are drawn. */
  casing(y, shift) {
    const { hole, travel, chuck } = this, steel = palette.casing;
    const back = Math.max(y(this.span[0] + shift) + 0.055 * this.height, 12);
    // The bit's collar has its travel between the upper end of this chamber and the ring.
    const top = y(shift), end = y(chuck + shift) - (travel ? 0 : 3);
    const ring = travel ? Math.min(y(shift + COLLAR * chuck + travel), end - 12) : top + 0.15 * (end - top);
    const lower = this.rods ? y(shift - this.string) : end;
    this.ring(0, back - 10, 0.3 * hole.bore, 0.75 * hole.casing, steel);
    this.ring(back - 10, back, 0.3 * hole.bore, hole.casing, steel);
    this.ring(back, lower, hole.bore, hole.casing, steel);
    if (this.rods) {
      this.ring(lower - 10, lower, 1.06 * hole.shank, hole.casing, steel);
      return { top: back, ring: lower, end: lower };
    }
    this.ring(top, ring, travel ? 1.03 * this.collar() : 1.06 * hole.shank, hole.casing, steel);
    this.ring(ring, end, 1.06 * hole.shank, hole.casing, steel);
    return { top: back, ring, end };
  }

  /** The chambers above and below the piston, by the pressure in them: as it is computed, or, of a drive
   * that is a force, the one that pushes. */
  chambers(y, tops, top, index) {
    const { pen, cycle, hole, middle } = this, force = cycle.applied_drive_force[index];
    const known = [cycle.drive_chamber_pressure, cycle.return_chamber_pressure].map((all) => all[index] / this.pressed);
    const parts = known.some((part) => part > 0)
        ? known : [1, -1].map((side) => Math.max(0, (side * force) / this.pushed));
    const piston = tops[0] + this.bodies[0].length, wide = this.x(hole.bore);
    const places = [[top, y(tops[0])], [y(this.shoulder(tops[0])), y(Math.max(piston, tops[1] - this.string))]];
    places.forEach(([from, to], i) => {
      if (to <= from) return;
      this.block(middle - wide, middle + wide, from, to, palette.paper);
      pen.globalAlpha = Math.min(1, parts[i]);
      this.block(middle - wide, middle + wide, from, to, palette.air);
      pen.globalAlpha = 1;
    });
    // The force on the piston, beside its axis.
    const long = (34 * Math.abs(force)) / this.pushed;
    if (long < 3) return;
    const down = force > 0, from = down ? y(tops[0]) - long - 4 : y(piston) + long + 4;
    for (const side of [-0.5, 0.5]) this.arrow(middle + side * this.x(hole.bore), from, down ? long : -long,
        palette.ink);
  }

  /** From where the lower chamber reaches around the piston: below its widest part. */
  shoulder(top) {
    const { ends } = this.bodies[0], [radii] = this.radii, widest = Math.max(...radii);
    const last = radii.findLastIndex((r) => r > 0.99 * widest);
    return top + ends[last + 1];
  }

  /** Shank and rods, shortened: a break in each. */
  rodsBetween(y, shift) {
    const { pen, middle, string, rods, hole } = this, [from, to] = [y(shift - string), y(shift)];
    const wide = this.x(0.72 * hole.shank), each = (to - from) / rods;
    for (let i = 0; i < rods; i++) {
      const top = from + i * each;
      Object.assign(pen, { fillStyle: palette.steel, strokeStyle: palette.bit, lineWidth: 1.5 });
      pen.fillRect(middle - wide, top, 2 * wide, each);
      pen.strokeRect(middle - wide, top, 2 * wide, each);
      pen.fillRect(middle - 1.5 * wide, top + each - 9, 3 * wide, 9);
      pen.strokeRect(middle - 1.5 * wide, top + each - 9, 3 * wide, 9);
      const cut = top + 0.45 * each;
      this.line([[middle - 1.3 * wide, cut + 6.5], [middle + 1.3 * wide, cut - 1.5]], palette.paper, 5);
    }
  }

  /** Radius of the collar by which the ring holds the bit. */
  collar() {
    const { shank, bore, casing } = this.hole;
    return Math.max(bore, 0.5 * (1.06 * shank + casing));
  }

  /** What ties bit and casing: the bit's collar, the retaining ring, and the shoulder on the chuck's
   * lower end. Whichever bears is coloured by its force, with an arrow that shows where it pushes the bit. */
  tie(y, bit, { ring, end }, force) {
    const { hole, chuck } = this, part = force / this.chuckLimit, collar = this.collar();
    const pressed = (share) => `rgb(${this.colours[shade(-Math.max(0, share))]})`;
    this.ring(y(bit), y(bit + COLLAR * chuck), hole.shank, collar, palette.steel, palette.bit);
    this.ring(ring, ring + 7, 1.06 * hole.shank, collar, pressed(-part), palette.bit);
    this.ring(end - 7, end, 1.06 * hole.shank, hole.casing, pressed(part), palette.bit);
    const way = Math.sign(part) * (8 + 34 * Math.abs(part));
    if (Math.abs(part) < 1e-3) return;
    for (const side of [-1, 1]) this.arrow(this.middle + side * this.x(0.5 * (hole.shank + hole.casing)),
        part > 0 ? end : ring, way, palette.compression);
  }

  /** An arrow along the axis. */
  arrow(level, from, way, colour) {
    const point = from + way, back = point - Math.min(7, Math.abs(way)) * Math.sign(way);
    for (const [stroke, width] of [[palette.paper, 5], [colour, 2.5]]) {
      this.line([[level, from], [level, point], [level - 4, back], [level, point], [level + 4, back]], stroke, width);
    }
  }

  /** A body: its elements by their stress, and its outline. */
  body(body, top, stress, y) {
    const { pen, middle } = this, { ends, length } = this.bodies[body], radii = this.radii[body].map((r) => this.x(r));
    if (body === 1 && this.head) {
      Object.assign(pen, { fillStyle: palette.steel, strokeStyle: palette.bit, lineWidth: 1.5 });
      const wide = this.x(this.head), from = y(top + (1 - HEAD) * length);
      pen.fillRect(middle - wide, from, 2 * wide, y(top + length) - from);
      pen.strokeRect(middle - wide, from, 2 * wide, y(top + length) - from);
    }
    const levels = Array.from(ends, (end) => y(top + end));
    stress.forEach((value, i) => {
      pen.fillStyle = `rgb(${this.colours[shade(value / this.limit)]})`;
      // Slightly longer, so that no seams show between elements.
      pen.fillRect(middle - radii[i], levels[i], 2 * radii[i], levels[i + 1] - levels[i] + 0.5);
    });
    for (const side of [-1, 1]) {
      const edge = radii.flatMap((wide, i) => [levels[i], levels[i + 1]].map((level) => [middle + side * wide, level]));
      this.line([[middle, levels[0]], ...edge, [middle, levels.at(-1)]], palette[BODIES[body]], 2);
    }
  }

  /** Round tips on the bit's face. */
  inserts(face) {
    const { pen, middle } = this, count = 5, size = this.x(Math.max(this.head, this.radii[1].at(-1))) / count;
    pen.fillStyle = palette.ink;
    for (let i = 0; i < count; i++) {
      pen.beginPath();
      pen.ellipse(middle + (2 * i - count + 1) * size, face - 1, 0.5 * size, Math.min(6, 0.5 * size), 0, 0, Math.PI);
      pen.fill();
    }
  }

  /** Names, each beside what it names. */
  words(room, y, tops, bottom, index) {
    const { pen, middle, hole, bodies, cycle } = this, at = middle + this.x(hole.radius) + 26;
    const down = cycle.applied_drive_force[index] > 0;
    const rows = [
      ["casing", this.x(0.5 * (hole.bore + hole.casing)), 0.5 * (y(this.span[0]) + y(tops[0])) - 12],
      [down ? "drives" : "vented", this.x(0.85 * hole.bore), y(tops[0]) - 8],
      ["piston", this.x(0.6 * this.radii[0][0]), y(tops[0] + 0.4 * bodies[0].length)],
      [down ? "vented" : "lifts", this.x(0.9 * this.radii[0].at(-1)), y(tops[0] + 0.93 * bodies[0].length)],
      ["bit", this.x(0.6 * hole.shank), y(tops[1] + 0.5 * this.chuck)],
      ["rock", this.x(0.4 * hole.radius), bottom + 14],
    ];
    pen.font = "600 13px system-ui, sans-serif";
    Object.assign(pen, { textBaseline: "middle", textAlign: "left" });
    let free = 0;
    for (const [key, from, wanted] of rows) {
      const level = Math.max(wanted, free, 10), most = room - at - 2;
      // Two lines rather than squeezed, on a phone.
      const lines = pen.measureText(say(key)).width > most ? say(key).split(/(?<=:) /) : [say(key)];
      free = level + 18 * lines.length;
      this.line([[middle + from, wanted], [at - 5, level]], palette.ink, 1);
      lines.forEach((text, i) => this.edged(text, at, level + 18 * i, most));
    }
  }

  /** The stress along both bodies, beside them. */
  stressCurve([left, right], y, tops, index) {
    const { pen } = this, middle = 0.5 * (left + right), most = Number((0.8 * this.limit * 1e-6).toPrecision(1));
    const x = (stress) => middle + (stress / this.limit) * 0.48 * (right - left), bottom = this.height - 34;
    pen.font = "12px system-ui, sans-serif";
    for (const value of [-most, 0, most]) {
      this.line([[x(value * 1e6), 4], [x(value * 1e6), bottom]], value === 0 ? palette.muted : palette.grid, 1);
      this.text(digits(value), x(value * 1e6), bottom + 9);
    }
    this.text(say(right - left < 170 ? "stress_short" : "stress_long"), middle, bottom + 25, "center",
        right - left + 16);
    BODIES.forEach((name, body) => {
      const { ends } = this.bodies[body], points = Array.from(this.cycle.stress[body][index],
          (value, i) => [x(value), y(tops[body] + 0.5 * (ends[i] + ends[i + 1]))]);
      this.line(points, palette[name], 2);
    });
  }
}

/** The largest size of a number in some lists. */
function largest(lists) {
  let most = 0;
  for (const list of lists) for (const value of list) most = Math.max(most, Math.abs(value));
  return most;
}
