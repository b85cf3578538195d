// The charts: uPlot, set up for this page.

/** Modes of the rock law: short names, colours that a colour-blind reader tells apart, and the
 * text that says what happens in them. */
const MODES = {
  FreeFlight: ["FF", () => palette.ff, "mode_ff"],
  DissipativeForward: ["DFC", () => palette.dfc, "mode_dfc"],
  Forward: ["FC", () => palette.fc, "mode_fc"],
  Backward: ["BC", () => palette.bc, "mode_bc"],
  Standstill: ["SS", () => palette.ss, "mode_ss"],
};
/** Outputs with the pressures above the piston and below it. */
const CHAMBERS = ["drive_chamber_pressure", "return_chamber_pressure"];
const LEVELS = { "open": -2.25, "closed": -1.25 };

const FONT = "12px system-ui, sans-serif";

function axes(x, y, more = {}) {
  const ink = () => palette.ink, grid = () => palette.grid;
  const values = (_, splits) => splits.map((value) => digits(value));
  const common = { values, stroke: ink, font: FONT, labelFont: FONT, grid: { stroke: grid, width: 1 },
      ticks: { stroke: grid, width: 1 } };
  return [
    { ...common, label: x, labelSize: 18, size: 28 },
    { ...common, label: y, labelSize: 18, size: 56, ...more },
  ];
}

/** A chart with the width of its element, and the height that the element sets or has. */
function chart(place, options, data) {
  const size = () => ({ width: Math.max(200, place.clientWidth),
      height: Number(place.dataset.height ?? Math.max(100, place.clientHeight)) });
  const plot = new uPlot({ ...size(), cursor: { drag: { x: false, y: false } }, legend: { show: false },
      padding: [8, 10, 0, 0], ...options }, data, place);
  new ResizeObserver(() => plot.setSize(size())).observe(place);
  return plot;
}

const line = (label, stroke, more = {}) => ({ label, stroke, width: 1.6, points: { show: false }, ...more });

/** A path through points in their own order, since a loop is not a function of x. */
function loop(plot, series) {
  const path = new Path2D();
  const [depth, force] = plot.data[series];
  let down = false;
  for (let i = 0; i < depth.length; i++) {
    if (force[i] === null) {
      down = false;
      continue;
    }
    const [x, y] = [plot.valToPos(depth[i], "x", true), plot.valToPos(force[i], "y", true)];
    if (down) path.lineTo(x, y);
    else path.moveTo(x, y);
    down = true;
  }
  return { stroke: path };
}

const [PISTON, BIT, ROCK, GHOST] = ["piston", "bit", "rock", "ghost"].map((name) => () => palette[name]);

/** The bit's displacement (mm) in an earlier cycle, at its own instants after the impact (ms). */
function ghostBit(time, before) {
  if (!before) return time.map(() => null);
  const { cycle, base } = before;
  let next = 0;
  return time.map((t) => {
    while (next < cycle.time.length && (cycle.time[next] - cycle.impact) * 1e3 < t) next++;
    return next < cycle.time.length ? (cycle.bit_position[next] - base) * 1e3 : null;
  });
}

/** Penetration (mm) and force (kN) after the impact in an earlier cycle. */
function ghostLoop(before) {
  if (!before) return [[], []];
  const { cycle, base } = before, until = Math.min(cycle.outlook, cycle.period);
  const inside = (_, i) => cycle.time[i] >= cycle.impact && cycle.time[i] <= cycle.impact + until;
  return [
    Array.from(cycle.bit_tip_position.filter(inside), (value) => (value - base) * 1e3),
    Array.from(cycle.rock_force.filter(inside), (value) => value * 1e-3),
  ];
}

/** A dot at each point. */
function dotted(plot, series) {
  const path = new Path2D(), [xs, ys] = plot.data[series], size = plot.series[series].dots * devicePixelRatio;
  xs.forEach((x, i) => {
    const [left, top] = [plot.valToPos(x, "x", true), plot.valToPos(ys[i], "y", true)];
    path.moveTo(left + size, top);
    path.arc(left, top, size, 0, 2 * Math.PI);
  });
  return { fill: path };
}

/** A series of a loop. */
const looped = ([label, stroke, more]) => ({
  label, stroke, width: 2, paths: loop, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }], ...more,
});

/** Position of a value on a chart, in CSS pixels from its upper left corner. */
function placing({ bbox: { left, top }, valToPos }) {
  const [x, y] = [left, top].map((pixels) => pixels / devicePixelRatio);
  return (across, up) => [x + valToPos(across, "x"), y + valToPos(up, "y")];
}

/** Draws the notes of a chart on its canvas. */
function noted(plot) {
  const { ctx } = plot;
  ctx.save();
  ctx.scale(devicePixelRatio, devicePixelRatio);
  ctx.font = FONT;
  plot.notes?.(new Drawing(ctx), placing(plot));
  ctx.restore();
}

/** Draws a chart on another canvas, as uPlot shows it. */
function traced(plot, canvas) {
  const pen = canvas.getContext("2d"), drawing = new Drawing(pen), at = placing(plot), [across, up] = plot.axes;
  const [left, top, width, height] = ["left", "top", "width",
      "height"].map((name) => plot.bbox[name] / devicePixelRatio), bottom = top + height;
  pen.font = FONT;
  (across._splits ?? []).forEach((value, i) => {
    const [x] = at(value, 0);
    drawing.line([[x, top], [x, bottom + 10]], palette.grid, 1);
    drawing.text(across._values[i], x, bottom + 20);
  });
  (up._splits ?? []).forEach((value, i) => {
    const [, y] = at(0, value);
    drawing.line([[left - 10, y], [left + width, y]], palette.grid, 1);
    drawing.text(up._values[i], left - 15, y, "right");
  });
  drawing.text(across.label, left + 0.5 * width, bottom + 36);
  drawing.upright(up.label, left - up._size - 8, top + 0.5 * height);
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  const lists = plot.series.map((_, i) => (plot.mode === 2 ? plot.data[i] : [plot.data[0], plot.data[i]]));
  const points = (i) => Array.from(lists[i][0], (x, k) => (lists[i][1][k] === null ? null : at(x, lists[i][1][k])));
  for (const { series: [from, to], fill } of plot.bands) {
    pen.beginPath();
    [...points(from), ...points(to).reverse()].forEach((point) => point && pen.lineTo(...point));
    pen.fillStyle = fill();
    pen.fill();
  }
  plot.series.forEach((series, i) => i && tracedSeries(drawing, plot, i, points(i)));
  pen.restore();
  plot.notes?.(drawing, at);
}

function tracedSeries(drawing, plot, i, points) {
  const series = plot.series[i], colour = series.stroke(plot, i);
  if (colour === "transparent") return;
  const size = series.dots ?? (plot.mode === 1 && series.points.show(plot, i) ? 0.5 * series.points.size : 0);
  if (size) points.forEach((point) => point && drawing.dot(...point, colour, size));
  if (series.dots) return;
  let part = [];
  for (const point of [...points, null]) {
    if (point && series.stepped && part.length) part.push([point[0], part.at(-1)[1]]);
    if (point) part.push(point);
    else if (part.length) drawing.line(part.splice(0), colour, series.width, series.dash);
  }
}

/** The range of a scale that shows all numbers, and zero. */
function ranged(list) {
  const [low, high] = [Math.min(0, ...list), Math.max(0, ...list)], margin = 0.04 * (high - low || 1);
  return { min: low - margin, max: high + margin };
}

/** All charts of the page. */
class Charts {
  constructor(find) {
    this.whole = true;
    const time = { x: { time: false } };
    const after = say("time_axis");
    const stepped = { paths: uPlot.paths.stepped({ align: 1 }), stepped: true };
    this.motion = chart(find("displacement"), {
      scales: time, axes: axes(after, say("displacement_axis")),
      series: [{}, line("piston", PISTON), line("bit", BIT), line("rock", ROCK, { dash: [6, 3] }),
          line("bit before", GHOST)],
    }, [[], [], [], [], []]);
    this.velocity = chart(find("velocity"), {
      scales: time, axes: axes(after, say("velocity_axis")),
      series: [{}, line("piston", PISTON), line("bit", BIT)],
    }, [[], [], []]);
    const names = new Map(Object.values(MODES).map(([short], level) => [level, short]));
    Object.entries(LEVELS).forEach(([name, level]) => names.set(level, say(name)));
    this.modes = chart(find("modes"), {
      scales: { ...time, y: { range: [-2.75, 4.5] } },
      axes: axes(after, say("modes_axis"), {
        size: 64,
        splits: () => [...names.keys()].sort((a, b) => a - b),
        values: (_, splits) => splits.map((level) => names.get(level)),
      }),
      series: [{}, line("rock", BIT, stepped), line("contact", () => palette.ink, stepped)],
    }, [[], [], []]);
    this.loops = chart(find("loops"), {
      mode: 2,
      scales: { x: { time: false }, y: {} },
      axes: axes(say("depth_of_tip_axis"), say("force_axis")),
      series: [null, ...[["before", GHOST], ...Object.values(MODES)].map(looped)],
    }, [null, [[], []], ...Object.keys(MODES).map(() => [[], []])]);
    this.indicator = chart(find("indicator"), {
      mode: 2,
      scales: { x: { time: false }, y: {} },
      axes: axes(say("height_axis"), " "),
      series: [null, ...[["above", PISTON], ["below", BIT], ["force", () => palette.ink]].map(looped)],
    }, [null, ...Array.from({ length: 3 }, () => [[], []])]);
    const dots = { points: { show: true, size: 6 } };
    const settling = (name, label, colour) =>
      chart(find(name), {
        scales: { ...time, y: { range: { min: { pad: 0.1 }, max: { pad: 0.1 } } } },
        axes: axes(say("blow_axis"), label), series: [{}, line("before", GHOST), line(label, colour, dots)],
      }, [[], [], []]);
    this.rop = settling("rop", say("rate_axis"), ROCK);
    this.frequency = settling("frequency", say("frequency_axis"), BIT);
    this.energy = settling("energy", say("energy_axis"), PISTON);
  }

  /** Shows the blows so far, and those of the previous setting. */
  settle(rows, before = []) {
    const number = Array.from({ length: Math.max(rows.length, before.length) }, (_, i) => i + 1);
    const show = (plot, value, always) => {
      const of = (list) => number.map((_, i) => (list[i] && (always || list[i].blow_period > 0)
          ? value(list[i]) : null));
      plot.setData([number, of(before), of(rows)]);
    };
    show(this.energy, (row) => row.blow_energy, true);
    show(this.rop, (row) => 3600 * row.rop);
    show(this.frequency, (row) => 1 / row.blow_period);
  }

  /** Draws everything again, because the colours have changed. */
  redraw() {
    [this.motion, this.velocity, this.modes, this.loops, this.indicator, this.rop, this.frequency,
        this.energy].forEach((plot) => plot.redraw());
  }

  /** Shows one cycle, from blow to blow.
   * With it, the cycle of the previous setting and its hole's depth at the impact, if there is one. */
  cycle(cycle, base, gap, modes, before = null) {
    const scaled = (list, by, offset = 0) => Array.from(list, (value) => (value + offset) * by);
    const time = scaled(cycle.time, 1e3, -cycle.impact);
    this.ends = [cycle.outlook * 1e3, cycle.period * 1e3];
    this.bit = scaled(cycle.bit_position, 1e3, -base);
    this.time = time;
    this.motion.setData(
      [time, scaled(cycle.piston_position, 1e3, -base - gap), this.bit, scaled(cycle.tip_depth, 1e3, -base),
          ghostBit(time, before)], false);
    this.velocity.setData([time, cycle.piston_velocity, cycle.bit_velocity].map((list) => Array.from(list)), false);
    const order = Object.keys(MODES);
    const level = Array.from(cycle.rock_mode, (mode) => order.indexOf(modes[mode]));
    const closed = Array.from(cycle.contact_closed, (shut) => (shut ? LEVELS.closed : LEVELS.open));
    this.modes.setData([time, level, closed], false);
    this.drawLoops(cycle, base, time, level, before);
    this.drawIndicator(cycle);
    this.zoom(this.whole);
  }

  /** Shows force against penetration after the impact, each piece in the colour of its mode. */
  drawLoops(cycle, base, time, level, before) {
    const depth = Array.from(cycle.bit_tip_position, (value) => (value - base) * 1e3);
    const force = Array.from(cycle.rock_force, (value) => value * 1e-3);
    const until = Math.min(...this.ends);
    const inside = time.map((t) => t >= 0 && t <= until);
    // A piece belongs to the mode at its start; a jump of the force belongs to the viscous mode.
    const owner = level.map((mode, i) => (mode === 1 || level[i + 1] === 1 ? 1 : mode));
    const of = (mode) => force.map((f, i) => (inside[i] && (owner[i] === mode || (i > 0 && owner[i - 1] === mode))
        ? f : null));
    const ghost = ghostLoop(before);
    this.loops.setData([null, ghost, ...Object.keys(MODES).map((_, mode) => [depth, of(mode)])], false);
    const near = (list, other) => [...list.filter((_, i) => inside[i]), ...other];
    this.loops.batch(() => {
      this.loops.setScale("x", ranged(near(depth, ghost[0])));
      this.loops.setScale("y", ranged(near(force, ghost[1])));
    });
  }

  /** Shows the chambers' pressures over the height of the piston, or the force of a drive without chambers. */
  drawIndicator(cycle) {
    const inside = (_, i) => cycle.time[i] >= cycle.impact && cycle.time[i] <= cycle.impact + cycle.period;
    const of = (name, by) => Array.from(cycle[name].filter(inside), (value) => value * by);
    const height = of("relative_position", -1e3), pressures = CHAMBERS.map((name) => of(name, 1e-5));
    const pressed = pressures.flat().some((pressure) => pressure > 0);
    const lists = pressed ? pressures : [[], [], of("applied_drive_force", 1e-3)];
    this.indicator.axes[1].label = say(pressed ? "pressure_axis" : "drive_force_axis");
    this.indicator.setData([null, ...[0, 1, 2].map((i) => (lists[i]?.length ? [height, lists[i]] : [[], []]))], false);
    this.indicator.batch(() => {
      this.indicator.setScale("x", ranged(height));
      this.indicator.setScale("y", ranged(lists.flat()));
    });
  }

  /** Shows the whole period, or the time after the impact. */
  zoom(whole) {
    this.whole = whole;
    if (!this.ends) return;
    const [outlook, period] = this.ends;
    const [min, max] = whole ? [-0.03 * period, 1.03 * period] : [-0.04 * outlook, Math.min(outlook, period)];
    for (const plot of [this.motion, this.velocity, this.modes]) {
      plot.batch(() => {
        plot.setScale("x", { min, max });
        if (plot !== this.modes) plot.setScale("y", this.range(plot, min, max));
      });
    }
  }

  range(plot, min, max) {
    // After the impact the bit is of interest, and the piston may leave the picture.
    const lists = plot === this.motion && !this.whole ? [this.bit] : plot.data.slice(1);
    let [low, high] = [Infinity, -Infinity];
    for (const list of lists) {
      list.forEach((value, i) => {
        if (this.time[i] < min || this.time[i] > max) return;
        [low, high] = [Math.min(low, value), Math.max(high, value)];
      });
    }
    const margin = lists.length === 1 ? high - low : 0.06 * (high - low);
    return { min: low - (margin || 1), max: high + (lists.length === 1 ? 0.4 * margin : margin) };
  }
}
