// Any mean against any slider: workers compute long-run responses, which are drawn as they arrive.

/** The engine's means that are offered (`dth_steady`): unit, factor from SI. */
const MEANS = {
  rop: ["m/h", 3600],
  tip_rate: ["mm/s", 1e3],
  blow_frequency: ["Hz", 1],
  blow_energy: ["J", 1],
  blow_speed: ["m/s", 1],
  air_flow: ["m³/min", 60],
  advance: ["mm", 1e3],
  rebound_ratio: ["", 1],
  contact_force_peak: ["kN", 1e-3],
  rock_force_peak: ["kN", 1e-3],
  energy_rock_dissipated: ["J", 1],
};
/** Points of a curve. */
const POINTS = 17;
/** So many standard errors are the half of a band that holds the mean in 95 of 100 cases. */
const BAND = 1.96;

class Curves {
  /** `sliders`: [name, range] of each; `engine` makes a worker with the engine in it. */
  constructor(scene, find, sliders, engine) {
    Object.assign(this, { scene, find, sliders, engine, crew: [], points: [], over: null });
    find("curve-of").append(...Object.keys(MEANS).map((name) => new Option(say(`mean_${name}`), name)));
    find("curve-over").append(...sliders.map(([name]) => new Option(say(name), name)));
    find("curve-start").addEventListener("click", () => (this.crew.length ? this.stop(say("stopped")) : this.start()));
    find("curve-of").addEventListener("change", () => this.draw());
    find("curve-start").textContent = say("draw");
    const ends = ["lower", "upper"].map((name) => line(name, () => "transparent"));
    const shown = { points: { show: true, size: 7 } };
    this.plot = chart(find("curve"), {
      scales: { x: { time: false }, y: { range: { min: { pad: 0.1, soft: 0, mode: 1 }, max: { pad: 0.1 } } } },
      axes: axes(" ", " "),
      series: [{}, ...ends, line("mean", () => palette.piston, shown),
          line("now", () => palette.ink, { points: { show: true, size: 11 } })],
      hooks: { draw: [noted] },
      bands: [{ series: [2, 1], fill: () => `${palette.piston}44` }],
    }, [[], [], [], [], []]);
    this.plot.notes = (drawing) => {
      if (!this.points.length) drawing.text(say("empty_until", { button: say("draw") }),
          0.5 * find("curve").clientWidth, 120);
    };
  }

  get busy() {
    return this.crew.length > 0;
  }

  start() {
    const name = this.find("curve-over").value;
    const [, range] = this.sliders.find(([other]) => other === name);
    const at = (i) => valueAt(name, range, (2 * i) / (POINTS - 1) - 1);
    const values = [...new Set([...Array.from({ length: POINTS }, (_, i) => at(i)), this.scene.get(name)])];
    values.sort((a, b) => a - b);
    const settings = { ...this.scene.changed };
    this.over = name;
    this.points = values.map((value) => ({ value, now: value === this.scene.get(name),
        settings: { ...settings, [name]: value } }));
    // The middle first, then outwards, so that the shape shows early.
    const middle = this.points.findIndex((point) => point.now);
    this.waiting = this.points.map((_, i) => i).sort((a, b) => Math.abs(b - middle) - Math.abs(a - middle));
    this.find("curve-start").textContent = say("stop");
    const count = Math.max(1, Math.min(4, (navigator.hardwareConcurrency || 2) - 1));
    for (let i = 0; i < count; i++) this.employ();
    this.draw();
  }

  employ() {
    const worker = this.engine((data) => this.receive(worker, data), (text) => this.stop(text));
    this.crew.push(worker);
    this.next(worker);
  }

  next(worker) {
    const task = this.waiting.pop();
    if (task === undefined) {
      worker.terminate();
      this.crew = this.crew.filter((other) => other !== worker);
      if (!this.busy) this.stop();
      return;
    }
    worker.postMessage({ kind: "mean", task, values: this.points[task].settings });
  }

  receive(worker, data) {
    if (!this.crew.includes(worker)) return;
    if (data.kind === "failed") this.stop(data.text);
    if (data.kind !== "mean") return;
    Object.assign(this.points[data.task], data);
    this.draw();
    this.next(worker);
  }

  stop(text) {
    this.crew.forEach((worker) => worker.terminate());
    this.crew = [];
    this.find("curve-start").textContent = say("draw");
    this.draw();
    if (text) this.find("curve-status").textContent = text;
  }

  /** The curve as far as it is known, for the output chosen. */
  draw() {
    const found = this.points.filter((point) => point.mean && point.response !== "stalled");
    const name = this.find("curve-of").value, [unit, factor] = MEANS[name], label = say(`mean_${name}`);
    const over = this.over && this.scene.variable(this.over);
    const x = found.map((point) => point.value * over.factor);
    const of = (list) => (point) => point[list][name] * factor;
    const mean = found.map(of("mean")), half = found.map((point) => BAND * of("error")(point));
    const band = (sign) => mean.map((m, i) => m + sign * half[i]);
    this.plot.axes[0].label = this.over ? `${say(this.over)}${unitOf(pretty(over.displayUnit))}` : " ";
    this.plot.axes[1].label = `${label}${unitOf(unit)}`;
    this.plot.setData([x, band(-1), band(1), mean, found.map((point, i) => (point.now ? mean[i] : null))]);
    this.describe(mean, label, unit);
  }

  describe(mean, label, unit) {
    if (!this.points.length) return;
    const count = (response) => this.points.filter((point) => point.response === response).length;
    const parts = [[count("cycle"), "curve_cycles"], [count("irregular"), "curve_irregular"],
      [count("stalled"), "curve_stalled"], [this.points.filter((point) => point.failure).length, "curve_failed"]];
    const told = parts.filter(([number]) => number > 0).map(([number, key]) => say(key, { number }));
    const heard = this.points.filter((point) => point.response || point.failure).length;
    const settings = say("curve_settings", { heard, all: this.points.length });
    this.find("curve-status").textContent = `${settings}${told.length ? `: ${told.join("; ")}` : ""}.`;
    if (mean.length) {
      const [low, high] = [Math.min(...mean), Math.max(...mean)].map((value) => digits(value, 3));
      this.find("curve").setAttribute("aria-label", say("curve_described", { label, low, high, unit }));
    }
  }
}

const unitOf = (unit) => (unit ? ` (${unit})` : "");
