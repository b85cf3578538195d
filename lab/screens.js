// The figures of the explanation except the hammer itself: bars as SVG, curves by uPlot.

const BOX = (width, height) => ({ left: 56, right: width - 14, top: 16, bottom: height - 46 });

class Figure extends Drawing {
  constructor(find) {
    super(new SvgPen(find("screen-chart")));
    const of = (name, most, labels, series, notes) => Object.assign(chart(find(`screen-${name}`), {
      mode: 2, scales: { x: { time: false, range: [0, most[0]] }, y: { range: [0, most[1]] } },
          axes: axes(...labels.map((label) => say(label))),
      series: [null, ...series.map(looped)], hooks: { draw: [noted] },
    }, [null, ...series.map(() => [[], []])]), { notes });
    const dot = (colour, dots = 6) => ["here", () => palette[colour], { paths: dotted, fill: () => palette[colour],
        dots }];
    this.canvas = this.pen;
    /** Figures that uPlot draws. */
    this.plots = {
      indicator: of("indicator", [100, 32], ["height_axis", "pressure_axis"],
          [["above", PISTON], ["below", BIT], dot("piston"), dot("bit")],
          (drawing, at) => ["chamber_above", "chamber_below"].forEach((name, k) => {
        const [x, y] = at(58, 31 - 2 * k);
        drawing.line([[x - 28, y], [x - 6, y]], palette[k ? "bit" : "piston"], 3);
        drawing.text(say(name), x, y, "left", at(100, 0)[0] - x);
      })),
      loop: of("loop", [4, 400], ["depth_axis_short", "force_axis"], [["all", GHOST], ["so far", ROCK], dot("ink")]),
      feed: of("feed", [18, 60], ["feed_axis", "rate_axis"], [["least", () => palette.muted, { dash: [5, 4] }],
          ["rate", ROCK], dot("rock", 4), dot("ink", 7)], (drawing, at) => {
        const [x, y] = at(this.least, 57);
        drawing.text(say("lifts_off"), x - 6, y, "right", x - at(0, 0)[0] - 8);
      }),
    };
  }

  /** An empty sheet; returns its size. */
  sheet() {
    const [width, height] = fit(this.canvas);
    this.pen.font = FONT;
    return [width, height];
  }

  /** An axis from 0 to the largest value, upward; returns where numbers are drawn. */
  upward({ left, right, top, bottom }, highest, beside) {
    const y = (v) => bottom - (v / highest) * (bottom - top);
    for (let i = 0; i <= 4; i++) {
      const value = (i / 4) * highest;
      this.line([[left, y(value)], [right, y(value)]], palette.grid, 1);
      this.text(digits(value, 3), left - 5, y(value), "right");
    }
    this.upright(beside, left - 44, 0.5 * (top + bottom), bottom - top);
    return y;
  }

  /** Pressure of both chambers over the piston's height, and where it is. */
  indicator({ answer: { cycle }, time }) {
    const [first, last] = periodOf(cycle), now = cycle.time.findIndex((t) => t >= time), here = now < 0 ? last : now;
    const part = (name, from, to) => columns(from, to, (i) => [Math.max(0, -1e3 * cycle.relative_position[i]),
        cycle[name][i] / BAR]);
    this.plots.indicator.setData([null, ...CHAMBERS.map((name) => part(name, first, last)),
        ...CHAMBERS.map((name) => part(name, here, here))]);
  }

  /** Force against depth of the tip: the whole curve grey, its part so far in colour. */
  loop({ answer: { cycle }, time }) {
    const [first] = periodOf(cycle),
        [last, then] = [cycle.impact + LOOP_LOOK, time].map((end) => cycle.time.findLastIndex((t) => t <= end)),
        now = Math.max(first, then);
    const part = (from, to) => columns(from, to,
        (i) => [Math.max(0, 1e3 * (cycle.bit_tip_position[i] - cycle.bit_tip_position[first])),
        1e-3 * cycle.rock_force[i]]);
    this.plots.loop.setData([null, part(first, last), part(first, now), part(now, now)]);
  }

  /** The energies that enter a blow, and those that leave it: two bars of equal height. */
  energy({ numbers: { drive, feed, rebound, work, damping } }) {
    const frame = BOX(...this.sheet()), y = this.upward(frame, 700, say("energy_axis")),
        wide = frame.right - frame.left;
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
        // If a part is too thin for its words, they are written above the bar.
        if (y(from) - y(from + size) > 14) this.text(shown, 0.5 * (left + right), middle, "center", 0.38 * wide,
            palette[fill === "piston" ? "paper" : "ink"]);
        else this.text(shown, 0.5 * (left + right), y(parts.reduce((sum, [, v]) => sum + Math.max(0, v), 0)) - 10,
            "center", 0.44 * wide);
        from += size;
      }
      this.text(say(name, { total: digits(from, 3) }), 0.5 * (left + right), frame.bottom + 16, "center", 0.46 * wide);
    });
  }

  /** The rate of penetration in the hardest possible rock, in this one, and in the easiest. */
  hole({ numbers: { low, rate, high } }) {
    const frame = BOX(...this.sheet()), y = this.upward(frame, 80, say("rate_axis")),
        each = (frame.right - frame.left) / 3;
    [["low", low], ["now", rate], ["high", high]].forEach(([name, value], i) => {
      const left = frame.left + (i + 0.2) * each;
      this.block(left, left + 0.6 * each, y(0), y(value), palette[name === "now" ? "piston" : "ghost"]);
      this.text(digits(value, 3), left + 0.3 * each, y(value) - 9);
      this.text(say(`bar_${name}`), left + 0.3 * each, frame.bottom + 14, "center", each);
    });
  }

  /** The rate over the feed, as far as it is known, and the feed that the piston's impulse requires. */
  feed({ row, place, numbers: { least } }) {
    const part = (rows) => columns(0, rows.length - 1, (i) => [1e-3 * rows[i][0], 3600 * rows[i][1].mean.mean.rop]),
        rates = part(row);
    this.least = least;
    this.plots.feed.setData([null, [[least, least], [0, 60]], rates, rates,
        part(row.filter(([feed]) => feed === place))]);
  }

  /** A top hammer on its rods and a down-the-hole hammer on its pipes, to scale, with the energy that the rock gets. */
  rods({ numbers: { rods, tight, loose, down } }) {
    const [width, height] = this.sheet(), room = 0.34 * width, ground = 40, foot = height - 34;
    // As deep as the longest string, of six rods.
    const metre = (foot - ground - 8) / 23, deep = ground + (0.6 + 3.66 * rods) * metre;
    this.block(0, room, ground, height, palette.ground);
    [["top_hammer_short", 0.27], ["down_short", 0.75]].forEach(([name, part], i) => {
      const x = part * room;
      this.block(x - 9, x + 9, ground, deep + 6, palette.paper);
      for (let rod = 0; rod < rods; rod++) {
        const from = ground + 0.5 * metre + 3.66 * rod * metre, to = from + 3.66 * metre;
        this.block(x - 3, x + 3, from, to - (i && rod === rods - 1 ? 1.2 * metre : 0),
            i ? palette.casing : palette.bit);
        if (!i) this.block(x - 5.5, x + 5.5, from - 3, from + 3, palette.ink);
      }
      // The hammer: above the hole, or at its bottom.
      if (i) this.block(x - 7, x + 7, deep - 1.4 * metre, deep, palette.piston);
      else this.block(x - 9, x + 9, ground - 22, ground + 2, palette.piston);
      this.block(x - 8, x + 8, deep, deep + 5, palette.ink);
      this.text(say(name), x, 9, "center", 0.48 * room);
    });
    const frame = { left: room + 50, right: width - 8, top: 16, bottom: height - 46 },
        each = (frame.right - frame.left) / 3;
    const y = this.upward(frame, 100, say("share_axis"));
    [["tight", tight, "bit"], ["loose", loose, "ghost"], ["down", down, "piston"]].forEach(([name, value, fill], i) => {
      const left = frame.left + (i + 0.15) * each;
      this.block(left, left + 0.7 * each, y(0), y(value), palette[fill]);
      this.text(digits(value, 3), left + 0.35 * each, y(value) - 9);
      this.text(say(`bar_${name}`), left + 0.35 * each, frame.bottom + (i % 2 ? 30 : 14), "center", 1.3 * each);
    });
  }
}

/** Points of a range of indices, as one list of x and one of y. */
function columns(from, to, point) {
  const points = Array.from({ length: to - from + 1 }, (_, i) => point(from + i));
  return [0, 1].map((k) => points.map((each) => each[k]));
}
