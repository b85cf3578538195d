// The figures of the explanation that are not the hammer itself.

const BOX = (width, height) => ({ left: 56, right: width - 14, top: 16, bottom: height - 46 });

class Figure {
  constructor(canvas) {
    Object.assign(this, { canvas, pen: canvas.getContext("2d") });
  }

  /** An empty sheet; returns its size. */
  sheet() {
    const [width, height] = fit(this.canvas);
    this.pen.fillStyle = palette.paper;
    this.pen.fillRect(0, 0, width, height);
    this.pen.font = "12px system-ui, sans-serif";
    return [width, height];
  }

  text(words, x, y, align = "center", room = undefined) {
    Object.assign(this.pen, { fillStyle: palette.ink, textAlign: align, textBaseline: "middle" });
    this.pen.fillText(words, x, y, room);
  }

  line(points, stroke, width = 2.5, dash = []) {
    const { pen } = this;
    Object.assign(pen, { strokeStyle: stroke, lineWidth: width });
    pen.setLineDash(dash);
    pen.beginPath();
    points.forEach(([x, y]) => pen.lineTo(x, y));
    pen.stroke();
    pen.setLineDash([]);
  }

  dot(x, y, fill = palette.ink, size = 6) {
    const { pen } = this;
    pen.fillStyle = fill;
    pen.beginPath();
    pen.arc(x, y, size, 0, 2 * Math.PI);
    pen.fill();
  }

  block(left, right, from, to, fill) {
    this.pen.fillStyle = fill;
    this.pen.fillRect(left, Math.min(from, to), right - left, Math.abs(to - from));
  }

  /** Axes from 0 to the largest values; returns where numbers are drawn. */
  axes({ left, right, top, bottom }, [most, highest], [below, beside]) {
    const { pen } = this, x = (v) => left + (v / most) * (right - left), y = (v) => bottom - (v / highest) * (bottom - top);
    for (let i = 0; i <= 4; i++) {
      const value = (i / 4) * highest;
      this.line([[left, y(value)], [right, y(value)]], palette.grid, 1);
      this.text(digits(value, 3), left - 5, y(value), "right");
      if (below) this.text(digits((i / 4) * most, 3), Math.min(right - 8, x((i / 4) * most)), bottom + 12);
    }
    if (below) this.text(below, 0.5 * (left + right), bottom + 32);
    pen.save();
    pen.translate(12, 0.5 * (top + bottom));
    pen.rotate(-Math.PI / 2);
    this.text(beside, 0, 0);
    pen.restore();
    return [x, y];
  }

  /** Pressure of both chambers over the piston's height, and where it is. */
  indicator({ answer: { cycle }, time }) {
    const [x, y] = this.axes(BOX(...this.sheet()), [100, 32], [say("height_axis"), say("pressure_axis")]), [first, last] = periodOf(cycle);
    const now = cycle.time.findIndex((t) => t >= time), above = (i) => Math.max(0, -1e3 * cycle.relative_position[i]);
    CHAMBERS.forEach((name, k) => {
      const colour = palette[k ? "bit" : "piston"], point = (i) => [x(above(i)), y(cycle[name][i] / BAR)];
      this.line(Array.from({ length: last - first + 1 }, (_, i) => point(first + i)), colour);
      this.dot(...point(now < 0 ? last : now), colour);
      const [, free, bottom] = [0, 26, 44];
      this.line([[x(52), (k ? bottom : free)], [x(57), (k ? bottom : free)]], colour, 3);
      this.text(say(k ? "chamber_below" : "chamber_above"), x(58.5), k ? bottom : free, "left", x(100) - x(58.5));
    });
  }

  /** Force against depth of the tip: all of it grey, up to now in colour. */
  loop({ answer: { cycle }, time }) {
    const [x, y] = this.axes(BOX(...this.sheet()), [4, 400], [say("depth_axis_short"), say("force_axis")]), [first] = periodOf(cycle);
    const last = cycle.time.findLastIndex((t) => t <= cycle.impact + LOOP_LOOK), now = cycle.time.findLastIndex((t) => t <= time);
    const point = (i) => [x(Math.max(0, 1e3 * (cycle.bit_tip_position[i] - cycle.bit_tip_position[first]))), y(1e-3 * cycle.rock_force[i])];
    const points = Array.from({ length: last - first + 1 }, (_, i) => point(first + i));
    this.line(points, palette.ghost, 1.5);
    this.line(points.slice(0, Math.max(1, now - first + 1)), palette.rock, 3);
    this.dot(...point(Math.max(first, now)));
  }

  /** What goes into a blow, and where it goes: two bars of one height. */
  energy({ numbers: { drive, feed, rebound, work, damping } }) {
    const frame = BOX(...this.sheet()), [, y] = this.axes(frame, [1, 700], ["", say("energy_axis")]), wide = frame.right - frame.left;
    const bars = [["energy_in", [["drive", drive, "air"], ["feed", feed, "casing"], ["rebound_in", rebound, "piston"]]],
      ["energy_out", [["rock", work, "ground"], ["damping", damping, "grid"], ["rebound_out", rebound, "piston"]]]];
    bars.forEach(([name, parts], i) => {
      const left = frame.left + wide * (0.06 + 0.48 * i), right = left + 0.4 * wide;
      let from = 0;
      for (const [part, value, fill] of parts) {
        const size = Math.max(0, value), middle = y(from + 0.5 * size);
        this.block(left, right, y(from), y(from + size), palette[fill]);
        this.line([[left, y(from + size)], [right, y(from + size)]], palette.paper, 1.5);
        const shown = `${say(`energy_${part}`)} ${digits(value, 3)} J`;
        // A part too thin for its words has them over the bar.
        if (y(from) - y(from + size) > 14) this.labelled(shown, 0.5 * (left + right), middle, 0.38 * wide, fill === "piston");
        else this.labelled(shown, 0.5 * (left + right), y(parts.reduce((sum, [, v]) => sum + Math.max(0, v), 0)) - 10, 0.44 * wide);
        from += size;
      }
      this.text(say(name, { total: digits(from, 3) }), 0.5 * (left + right), frame.bottom + 16, "center", 0.46 * wide);
    });
  }

  labelled(words, x, y, room, light = false) {
    this.text(words, x, y, "center", room);
    if (!light) return;
    this.pen.fillStyle = palette.paper;
    this.pen.fillText(words, x, y, room);
  }

  /** The rate of the hole in the hardest rock that is possible, in this one, in the easiest. */
  hole({ numbers: { low, rate, high } }) {
    const frame = BOX(...this.sheet()), [, y] = this.axes(frame, [1, 80], ["", say("rate_axis")]), each = (frame.right - frame.left) / 3;
    [["low", low], ["now", rate], ["high", high]].forEach(([name, value], i) => {
      const left = frame.left + (i + 0.2) * each;
      this.block(left, left + 0.6 * each, y(0), y(value), palette[name === "now" ? "piston" : "ghost"]);
      this.text(digits(value, 3), left + 0.3 * each, y(value) - 9);
      this.text(say(`bar_${name}`), left + 0.3 * each, frame.bottom + 14, "center", each);
    });
  }

  /** The rate over the feed, as far as it is known, and what the piston's impulse asks for. */
  feed(page) {
    const frame = BOX(...this.sheet()), [x, y] = this.axes(frame, [12, 60], [say("feed_axis"), say("rate_axis")]), { row, place, numbers: { least } } = page;
    const point = ([feed, { mean }]) => [x(1e-3 * feed), y(3600 * mean.mean.rop)];
    this.line([[x(least), y(0)], [x(least), y(56)]], palette.muted, 1.5, [5, 4]);
    this.text(say("lifts_off"), x(least) - 6, y(56), "right", x(least) - frame.left - 8);
    this.line(row.map(point), palette.rock);
    row.forEach((each) => this.dot(...point(each), palette.rock, 4));
    const here = row.find(([feed]) => feed === place);
    if (here) this.dot(...point(here), palette.ink, 7);
  }

  /** A top hammer on its rods and a down-the-hole hammer on its pipes, to one scale, and what they give the rock. */
  rods({ numbers: { rods, tight, loose, down } }) {
    const [width, height] = this.sheet(), room = 0.34 * width, ground = 40, foot = height - 34;
    // As deep as the longest string stands: six rods.
    const metre = (foot - ground - 8) / 23, deep = ground + (0.6 + 3.66 * rods) * metre;
    this.block(0, room, ground, height, palette.ground);
    [["top_hammer_short", 0.27], ["down_short", 0.75]].forEach(([name, part], i) => {
      const x = part * room;
      this.block(x - 9, x + 9, ground, deep + 6, palette.paper);
      for (let rod = 0; rod < rods; rod++) {
        const from = ground + 0.5 * metre + 3.66 * rod * metre, to = from + 3.66 * metre;
        this.block(x - 3, x + 3, from, to - (i && rod === rods - 1 ? 1.2 * metre : 0), i ? palette.casing : palette.bit);
        if (!i) this.block(x - 5.5, x + 5.5, from - 3, from + 3, palette.ink);
      }
      // The hammer: above the hole, or at its bottom.
      if (i) this.block(x - 7, x + 7, deep - 1.4 * metre, deep, palette.piston);
      else this.block(x - 9, x + 9, ground - 22, ground + 2, palette.piston);
      this.block(x - 8, x + 8, deep, deep + 5, palette.ink);
      this.text(say(name), x, 9, "center", 0.48 * room);
    });
    const frame = { left: room + 50, right: width - 8, top: 16, bottom: height - 46 }, each = (frame.right - frame.left) / 3;
    const [, y] = this.axes({ ...frame, left: frame.left }, [1, 100], ["", ""]);
    this.pen.save();
    this.pen.translate(room + 12, 0.5 * (frame.top + frame.bottom));
    this.pen.rotate(-Math.PI / 2);
    this.text(say("share_axis"), 0, 0, "center", frame.bottom - frame.top);
    this.pen.restore();
    [["tight", tight, "bit"], ["loose", loose, "ghost"], ["down", down, "piston"]].forEach(([name, value, fill], i) => {
      const left = frame.left + (i + 0.15) * each;
      this.block(left, left + 0.7 * each, y(0), y(value), palette[fill]);
      this.text(digits(value, 3), left + 0.35 * each, y(value) - 9);
      this.text(say(`bar_${name}`), left + 0.35 * each, frame.bottom + (i % 2 ? 30 : 14), "center", 1.3 * each);
    });
  }
}
