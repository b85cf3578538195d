// The charts: uPlot, set up for this page.

/** Modes of the rock law: short names and colours that a colour-blind reader tells apart. */
const MODES = {
  FreeFlight: ["FF", "#767676"],
  DissipativeForward: ["DFC", "#d55e00"],
  Forward: ["FC", "#b8860b"],
  Backward: ["BC", "#3a8fc4"],
  Standstill: ["SS", "#009e73"],
};
const LEVELS = { open: -2.25, closed: -1.25 };

const FONT = "12px system-ui, sans-serif";

function axes(x, y, more = {}) {
  const common = { stroke: INK, font: FONT, labelFont: FONT, grid: { stroke: "#e6e6e6", width: 1 }, ticks: { stroke: "#bbb", width: 1 } };
  return [
    { ...common, label: x, labelSize: 18, size: 28 },
    { ...common, label: y, labelSize: 18, size: 56, ...more },
  ];
}

/** A chart that is as wide as its place. */
function chart(place, options, data) {
  const height = Number(place.dataset.height);
  const size = () => ({ width: Math.max(200, place.clientWidth), height });
  const plot = new uPlot({ ...size(), cursor: { drag: { x: false, y: false } }, legend: { show: false }, padding: [8, 10, 0, 0], ...options }, data, place);
  new ResizeObserver(() => plot.setSize(size())).observe(place);
  return plot;
}

const line = (label, stroke, more = {}) => ({ label, stroke, width: 1.6, points: { show: false }, ...more });

/** A path through points in their own order: a loop is no function. */
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

/** All charts of the page. */
class Charts {
  constructor(find) {
    this.whole = true;
    const time = { x: { time: false } };
    const after = "time since impact (ms)";
    const stepped = { paths: uPlot.paths.stepped({ align: 1 }) };
    this.motion = chart(find("displacement"), {
      scales: time, axes: axes(after, "displacement (mm)"),
      series: [{}, line("piston", PISTON), line("bit", BIT), line("rock", ROCK, { dash: [6, 3] })],
    }, [[], [], [], []]);
    this.velocity = chart(find("velocity"), {
      scales: time, axes: axes(after, "mean velocity (m/s)"),
      series: [{}, line("piston", PISTON), line("bit", BIT)],
    }, [[], [], []]);
    const names = new Map(Object.values(MODES).map(([short], level) => [level, short]));
    Object.entries(LEVELS).forEach(([name, level]) => names.set(level, name));
    this.modes = chart(find("modes"), {
      scales: { ...time, y: { range: [-2.75, 4.5] } },
      axes: axes(after, "contact | rock mode", {
        size: 64,
        splits: () => [...names.keys()].sort((a, b) => a - b),
        values: (_, splits) => splits.map((level) => names.get(level)),
      }),
      series: [{}, line("rock", BIT, stepped), line("contact", "#444", stepped)],
    }, [[], [], []]);
    this.loops = chart(find("loops"), {
      mode: 2,
      scales: { x: { time: false }, y: {} },
      axes: axes("bit face below the hole before the blow (mm)", "rock force (kN)"),
      series: [
        null,
        ...Object.values(MODES).map(([short, colour]) => ({
          label: short, stroke: colour, width: 2, paths: loop,
          facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
        })),
      ],
    }, [null, ...Object.keys(MODES).map(() => [[], []])]);
    const dots = { points: { show: true, size: 6 } };
    const settling = (name, label, colour) =>
      chart(find(name), {
        scales: { ...time, y: { range: { min: { pad: 0.1 }, max: { pad: 0.1 } } } },
        axes: axes("blow", label), series: [{}, line(label, colour, dots)],
      }, [[], []]);
    this.rop = settling("rop", "ROP (mm/s)", ROCK);
    this.frequency = settling("frequency", "frequency (Hz)", BIT);
    this.energy = settling("energy", "energy per blow (J)", PISTON);
  }

  /** The blows so far. */
  settle(rows) {
    const number = rows.map((_, i) => i + 1);
    const paired = rows.map((row) => row.blow_period > 0);
    const when = (values) => values.map((value, i) => (paired[i] ? value : null));
    this.energy.setData([number, rows.map((row) => row.blow_energy)]);
    this.rop.setData([number, when(rows.map((row) => 1e3 * row.rop))]);
    this.frequency.setData([number, when(rows.map((row) => 1 / row.blow_period))]);
  }

  /** One cycle, from blow to blow. */
  cycle(cycle, base, gap, modes) {
    const scaled = (list, by, offset = 0) => Array.from(list, (value) => (value + offset) * by);
    const time = scaled(cycle.time, 1e3, -cycle.impact);
    this.ends = [cycle.outlook * 1e3, cycle.period * 1e3];
    this.bit = scaled(cycle.bit_position, 1e3, -base);
    this.time = time;
    this.motion.setData(
      [time, scaled(cycle.piston_position, 1e3, -base - gap), this.bit, scaled(cycle.hole_depth, 1e3, -base)], false);
    this.velocity.setData([time, cycle.piston_velocity, cycle.bit_velocity].map((list) => Array.from(list)), false);
    const order = Object.keys(MODES);
    const level = Array.from(cycle.rock_mode, (mode) => order.indexOf(modes[mode]));
    const closed = Array.from(cycle.contact_closed, (shut) => (shut ? LEVELS.closed : LEVELS.open));
    this.modes.setData([time, level, closed], false);
    this.drawLoops(cycle, base, time, level);
    this.zoom(this.whole);
  }

  /** Force against penetration after the impact, each piece in the colour of its mode. */
  drawLoops(cycle, base, time, level) {
    const depth = Array.from(cycle.bit_tip_position, (value) => (value - base) * 1e3);
    const force = Array.from(cycle.rock_force, (value) => value * 1e-3);
    const until = Math.min(...this.ends);
    const inside = time.map((t) => t >= 0 && t <= until);
    // A piece belongs to the mode at its start; a jump of the force, to the viscous mode.
    const owner = level.map((mode, i) => (mode === 1 || level[i + 1] === 1 ? 1 : mode));
    const of = (mode) => force.map((f, i) => (inside[i] && (owner[i] === mode || (i > 0 && owner[i - 1] === mode)) ? f : null));
    this.loops.setData([null, ...Object.keys(MODES).map((_, mode) => [depth, of(mode)])], false);
    const near = (list) => list.filter((_, i) => inside[i]);
    const range = (list, from) => {
      const [low, high] = [Math.min(from, ...list), Math.max(from, ...list)];
      const margin = 0.04 * (high - low || 1);
      return { min: low - margin, max: high + margin };
    };
    this.loops.batch(() => {
      this.loops.setScale("x", range(near(depth), 0));
      this.loops.setScale("y", range(near(force), 0));
    });
  }

  /** The whole period, or what follows the impact. */
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
    // After the impact the bit is what one looks at: the piston may leave the picture.
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
