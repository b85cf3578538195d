// A hole through layers, drilled while one watches, with a log over depth as a driller has it.

/** The layers to begin with, as the page says where they are from: thickness (m), loading stiffness
 * over that of the scene, work per volume of rock (MJ/m³). */
const LAYERS = [["soft", 0.3, 0.6, 150], ["medium", 0.3, 1, 250], ["hard", 0.3, 2.5, 399]];
const LAYER_NUMBERS = [["thickness", 0.01, 100], ["layer_stiffness", 0.01, 100], ["layer_energy", 1, 5000]];
/** Rows of the log, about. */
const LOG_ROWS = 90;
/** Tracks of the log: name, unit, value of a row in that unit, colour. */
const TRACKS = [
  ["track_rate", "m/h", (row) => 3600 * row.rate, "rock"],
  ["track_frequency", "Hz", (row) => row.frequency, "bit"],
  ["track_energy", "J", (row) => row.energy, "piston"],
  ["track_force", "kN", (row) => 1e-3 * row.peak, "ink"],
];

class Drill {
  /** `engine` makes a worker with the engine in it. */
  constructor(scene, find, engine) {
    Object.assign(this, { scene, find, engine, worker: null, number: 0, rows: [], layers: [], depth: 0 });
    this.canvas = find("log");
    this.makeLayers();
    find("drill-start").addEventListener("click", () => (this.worker ? this.stop() : this.start()));
    find("drill-save").addEventListener("click", () => save("log.csv", this.csv(), "text/csv"));
    find("drill-pace").addEventListener("input", () => this.tune({}));
    for (const id of ["drill-feed", "drill-drive"]) {
      find(id).addEventListener("input", () => {
        this.label();
        this.tune(this.setPoints());
      });
    }
    this.label();
    find("drill-start").textContent = say("drill");
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  makeLayers() {
    const body = this.find("layers");
    LAYERS.forEach(([name, ...numbers], i) => {
      const row = document.createElement("tr");
      row.append(Object.assign(document.createElement("th"), { textContent: say(name), scope: "row" }));
      numbers.forEach((value, k) => {
        const [what, min, max] = LAYER_NUMBERS[k];
        const input = Object.assign(document.createElement("input"), { type: "number", id: `layer-${i}-${k}`, value, min, max, step: "any" });
        input.setAttribute("aria-label", say("layer_field", { layer: say(name), what: say(what) }));
        const cell = document.createElement("td");
        cell.append(input);
        row.append(cell);
      });
      body.append(row);
    });
  }

  /** The layers as the form has them, or why they cannot be. */
  read() {
    let bottom = 0;
    return LAYERS.map(([name], i) => {
      const numbers = LAYER_NUMBERS.map(([what, min, max], k) => {
        const value = this.find(`layer-${i}-${k}`).valueAsNumber;
        if (!(value >= min && value <= max)) throw new Error(say("layer_range", { layer: say(name), what: say(what), min, max }));
        return value;
      });
      bottom += numbers[0];
      const stiffness = numbers[1] * this.scene.get("rock.stiffness");
      return { name: say(name), bottom, values: { "rock.stiffness": stiffness, "rock.specific_energy": 1e6 * numbers[2] } };
    });
  }

  /** Feed and drive as the sliders have them, parts of the scene's. A drive from elsewhere than the
   * pressure law, which is what scenes begin with, has no such force. */
  setPoints() {
    const { scene } = this, points = { feed_force: this.find("drill-feed") };
    if (scene.get("drive.source") === scene.variable("drive.source").start) points["drive.amplitude"] = this.find("drill-drive");
    return Object.fromEntries(Object.entries(points).map(([name, { valueAsNumber }]) => [name, (valueAsNumber / 100) * scene.get(name)]));
  }

  label() {
    const points = this.setPoints();
    this.find("drill-drive").parentElement.hidden = !("drive.amplitude" in points);
    for (const [id, name] of [["drill-feed", "feed_force"], ["drill-drive", "drive.amplitude"]]) {
      const { factor, displayUnit } = this.scene.variable(name);
      const text = `${digits((points[name] ?? 0) * factor, 3)} ${displayUnit}`;
      this.find(`${id}-text`).textContent = text;
      this.find(id).setAttribute("aria-valuetext", text);
    }
  }

  pace() {
    return 10 ** this.find("drill-pace").valueAsNumber;
  }

  tune(values) {
    this.worker?.postMessage({ kind: "tune", values, pace: this.pace() });
  }

  start() {
    try {
      this.layers = this.read();
    } catch (error) {
      this.say(error.message, true);
      return;
    }
    this.number += 1;
    Object.assign(this, { rows: [], settings: [], depth: 0, layer: 0 });
    const fail = (text) => {
      this.stop();
      this.say(text, true);
    };
    this.worker = this.engine((data) => (data.kind === "failed" ? fail(data.text) : this.receive(data)), fail);
    const bottom = this.layers.at(-1).bottom;
    this.worker.postMessage({
      kind: "drill", hole: this.number, values: { ...this.scene.changed, ...this.setPoints() },
      layers: this.layers, every: bottom / LOG_ROWS, pace: this.pace(),
    });
    this.find("drill-start").textContent = say("stop");
    this.say(say("drilling"));
    this.draw();
  }

  stop() {
    this.worker?.terminate();
    this.worker = null;
    this.find("drill-start").textContent = say("drill");
  }

  receive({ hole, rows, settings, depth, layer, time, done, stuck }) {
    if (hole !== this.number || !this.worker) return;
    Object.assign(this, { rows, settings, depth, layer, time });
    this.show();
    this.draw();
    if (!done) return;
    this.stop();
    const took = time < 90 ? `${digits(time, 3)} s` : `${digits(time / 60, 3)} min`;
    this.say(say(stuck ? "drill_stuck" : "drill_done", { depth: digits(depth, 3), took }), stuck);
  }

  say(text, failed = false) {
    Object.assign(this.find("drill-status"), { textContent: text, className: failed ? "status failed" : "status" });
  }

  show() {
    const last = this.rows.at(-1), { find } = this;
    find("drill-depth").textContent = `${fixed(this.depth, 3)} m`;
    find("drill-layer").textContent = this.layers[Math.min(this.layer, this.layers.length - 1)].name;
    TRACKS.forEach(([, unit, value], i) => {
      find(`drill-track-${i}`).textContent = last ? `${digits(value(last), 3)} ${unit}` : "–";
    });
    const means = TRACKS.map(([name], i) => `${say(name)} ${find(`drill-track-${i}`).textContent}`);
    this.canvas.setAttribute("aria-label", say("log_described", { depth: fixed(this.depth, 2), means: means.join(", ") }));
  }

  /** Every row with the set points, as comma-separated values. */
  csv() {
    const head = "depth (m),time (s),layer,rate (m/h),frequency (Hz),energy (J),peak force of the rock (kN)";
    const lines = this.rows.map((row) =>
      [row.depth, row.time, this.layers[row.layer].name, ...TRACKS.map(([, , value]) => value(row))].join(","));
    return [head, ...lines, ""].join("\n");
  }

  /** The log: layers, then a track for each number, depth downward. */
  draw() {
    const [width, height] = fit(this.canvas), pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, width, height);
    const layers = this.layers.length ? this.layers : this.readable();
    if (!layers) return;
    const bottom = layers.at(-1).bottom, top = 40, low = height - 8;
    const y = (depth) => top + (depth / bottom) * (low - top);
    const column = Math.min(90, 0.2 * width), room = (width - column - 8) / TRACKS.length;
    pen.font = `${width < 450 ? 11 : 12}px system-ui, sans-serif`;
    this.ground(pen, layers, y, column);
    TRACKS.forEach((track, i) => this.track(pen, track, y, [column + i * room + 8, column + (i + 1) * room], [top, low]));
    if (!this.rows.length && !this.worker) invite(pen, 0.5 * (column + width), 0.5 * (top + low), "drill");
  }

  readable() {
    try {
      return this.read();
    } catch {
      return null;
    }
  }

  /** The rock with its layers, and the hole in it. */
  ground(pen, layers, y, column) {
    let from = 0;
    layers.forEach(({ name, bottom }, i) => {
      pen.fillStyle = palette.ground;
      pen.fillRect(34, y(from), column - 34, y(bottom) - y(from));
      pen.strokeStyle = palette.rock;
      pen.lineWidth = 0.4 + 0.5 * i;
      pen.beginPath();
      // Closer lines in the lower layers.
      for (let at = y(from) + 3; at < y(bottom); at += 12 - 3 * i) {
        pen.moveTo(34, at);
        pen.lineTo(column, at);
      }
      pen.stroke();
      pen.fillStyle = palette.ink;
      pen.textAlign = "right";
      pen.textBaseline = "bottom";
      pen.fillText(digits(bottom, 3), 31, y(bottom) + 2);
      pen.save();
      pen.translate(46, 0.5 * (y(from) + y(bottom)));
      pen.rotate(-Math.PI / 2);
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      pen.lineWidth = 4;
      pen.strokeStyle = palette.paper;
      pen.strokeText(name, 0, 0);
      pen.fillText(name, 0, 0);
      pen.restore();
      from = bottom;
    });
    pen.fillStyle = palette.paper;
    const middle = 0.5 * (56 + column);
    pen.fillRect(middle - 7, y(0), 14, y(this.depth) - y(0));
    pen.fillStyle = palette.casing;
    pen.fillRect(middle - 5, y(0) - 8, 10, y(this.depth) - y(0) + 8);
    pen.fillStyle = palette.ink;
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    pen.fillText(say("depth_axis"), 0, 12);
  }

  track(pen, [name, unit, value, colour], y, [left, right], [top, low]) {
    const values = this.rows.map(value).filter(Number.isFinite);
    const most = rounded(Math.max(...values, 1e-9));
    const x = (number) => left + (number / most) * (right - left - 6);
    pen.strokeStyle = palette.grid;
    pen.lineWidth = 1;
    pen.strokeRect(left, top, right - left - 6, low - top);
    pen.fillStyle = palette.ink;
    pen.textBaseline = "middle";
    pen.textAlign = "left";
    pen.fillText(say(name), left, 10);
    pen.fillText(values.length ? `0–${digits(most, 2)} ${unit}` : unit, left, 26);
    pen.strokeStyle = palette[colour];
    pen.lineWidth = 2;
    pen.beginPath();
    let from = 0;
    this.rows.forEach((row, i) => {
      const at = x(value(row));
      if (i === 0) pen.moveTo(at, y(from));
      else pen.lineTo(at, y(from));
      pen.lineTo(at, y(row.depth));
      from = row.depth;
    });
    pen.stroke();
  }
}

/** The next larger of 1, 1.5, 2, 3, 4, 6, 8 times a power of ten. */
function rounded(number) {
  const power = 10 ** Math.floor(Math.log10(number));
  return power * [1, 1.5, 2, 3, 4, 6, 8, 10].find((step) => step * power >= 0.999 * number);
}
