// The explanation: eight screens, each with a figure and a slider. Predictions in the texts are computed from the
// scene (told.js) and compared with the engine's results.

/** A mesh whose elements are less than half as long as the front that the contact makes, which keeps its shape. */
const WAVE_MESH = { "mesh.degree": 3, "piston.elements": 48, "bit.elements": 48 };
/** A loose joint: faces as stiff as a tenth of a metre of rod, half a millimetre of play. */
const LOOSE = { "drill.joint.stiffness": 3e9, "drill.joint.slack": 5e-4 };
/** Relative error and number of blows of a mean here. */
const MEAN_OF = { error: 0.02, blows: 200 }, MEAN_OF_RODS = { error: 0.04, blows: 120 };
/** One scale for all positions of a slider: stress and pressure (Pa) of the full colour, the piston's rise (m). */
const SCALE = { limit: 2.9e8, pressed: 3.1e6, flown: 0.1 };
const BAR = 1e5;
/** Times after an impact at which figures are drawn, s. */
const WAVE_LOOK = 2e-4, LOOP_LOOK = 1.2e-3;
/** Duration for which a slider of time plays from end to end, s. */
const PLAYED = 6;

class Explore {
  /** `engine` makes a worker; `presets` are the scenes to start from. */
  constructor(find, engine, description, presets) {
    Object.assign(this, { find, engine, description, screen: 0, cache: new Map(), known: new Map(), settled: false,
        playing: false, phase: 0.3, numbers: {} });
    this.hammer = { ...presets.air_3_5_inch.start_values, ...WAVE_MESH };
    this.drifter = { ...presets.top_hammer.start_values };
    this.picture = new Picture(new SvgPen(find("screen-hammer")));
    this.figure = new Figure(find);
    const moments = Array.from({ length: 201 }, (_, i) => i), [easy, hard] = this.rocks();
    const plain = () => this.hammer, changed = (more) => ({ ...this.hammer, ...more }), { cycles, waves, loops } = {
      cycles: (c, at) => c.impact + (c.period * at) / 200,
      waves: (c, at) => c.impact + (WAVE_LOOK * at) / 200,
      loops: (c, at) => c.impact + (LOOP_LOOK * at) / 200,
    };
    /** Each screen has the slider's positions, its first position and unit, and the scene at a position.
     * It may have the moment of the cycle to draw, and a chart that replaces the hammer. */
    this.screens = [
      { places: [6, 8, 10, 12, 14, 17, 20, 24, 28], begin: 7, unit: "bar",
          scene: (bar) => changed({ supply_pressure: bar * BAR + ATMOSPHERE }), moment: cycles },
      { places: moments, begin: 60, unit: "ms", scene: plain, moment: cycles, chart: "indicator" },
      { places: moments, begin: 32, unit: "µs", scene: plain, moment: waves },
      { places: moments, begin: 60, unit: "ms", scene: plain, moment: loops, chart: "loop" },
      { places: [0.25, 0.35, 0.5, 0.7, 1, 1.4, 2, 2.8, 4], begin: 4, unit: "×",
          scene: (times) => changed({ "rock.stiffness": times * this.value("rock.stiffness") }), chart: "energy" },
      { places: geometric(easy, hard, 19), begin: 9, unit: "MJ/m³", scale: 1e-6,
          scene: (energy) => changed({ "rock.specific_energy": energy }), chart: "hole" },
      { places: Array.from({ length: 12 }, (_, i) => 1.5e3 * (i + 1)), begin: 5, unit: "kN", scale: 1e-3,
          scene: (feed) => changed({ feed_force: feed }), chart: "feed" },
      { places: [1, 2, 3, 4, 6], begin: 3, unit: "",
          scene: (rods) => ({ ...this.drifter, "drill.rods": rods, "bit.elements": 20 + 16 * rods }), chart: "rods",
          of: MEAN_OF_RODS },
    ];
    this.at = this.screens.map(({ begin }) => begin);
    find("screen-handle").addEventListener("input", ({ target }) => {
      if (!this.screens[this.screen].phased) this.play(false);
      this.move(target.valueAsNumber);
    });
    find("screen-play").addEventListener("click", () => this.play(!this.playing));
    find("screen-back").addEventListener("click", () => this.go(this.screen - 1));
    find("screen-next").addEventListener("click", () => this.go(this.screen + 1));
  }

  value(name, values = this.hammer) {
    return values[name] ?? this.description.variables[name].start;
  }

  /** The least and the most work that breaks a volume of rock, if nothing is known about the rock, J/m³. */
  rocks() {
    const [energy, factor] = ["rock.specific_energy", "rock.specific_energy_factor"].map((name) => this.value(name));
    return [energy / factor, energy * factor];
  }

  go(screen) {
    const { find } = this;
    if (screen >= this.screens.length) return (location.hash = "laboratory");
    Object.assign(this, { screen: Math.max(0, screen), answer: null });
    history.replaceState(null, "", `#screen=${this.screen + 1}`);
    const { places, moment } = this.screens[this.screen], number = this.screen + 1;
    find("screen-title").textContent = say("screen_step",
        { step: number, all: this.screens.length, title: say(`screen_${number}_title`) });
    find("screen-label").textContent = say(`screen_${number}_handle`);
    Object.assign(find("screen-handle"), { min: 0, max: places.length - 1, value: this.at[this.screen] });
    find("screen-back").disabled = this.screen === 0;
    find("screen-next").textContent = say(`screen_${number}_next`);
    for (const id of ["screen-text", "screen-value"]) find(id).textContent = "";
    find("screen-player").hidden = !moment;
    this.play(Boolean(moment) && !matchMedia("(prefers-reduced-motion: reduce)").matches);
    return this.move(this.at[this.screen]);
  }

  async move(at) {
    this.at[this.screen] = at;
    this.settled = false;
    const { screen } = this, { places } = this.screens[screen];
    try {
      const found = await this.answerAt(screen, places[at]);
      if (screen !== this.screen || at !== this.at[screen]) return;
      Object.assign(this, { answer: found, place: places[at] });
      this.show();
    } catch (error) {
      this.find("screen-text").textContent = say("screen_failed");
      this.failure = error.message;
    }
    this.settled = true;
    if (places.length < 40) this.ahead(screen);
  }

  /** The engine's results for a position of a slider, and for the scenes with which the text compares it. */
  async answerAt(screen, place) {
    const { scene, moment, chart, of = MEAN_OF } = this.screens[screen], values = scene(place);
    const mean = await this.ask("mean", values, of), answer = { values, mean };
    if (moment) answer.cycle = (await this.ask("explore", values)).cycle;
    if (chart === "rods") answer.loose = await this.ask("mean", { ...values, ...LOOSE }, of);
    if (["rods", "feed"].includes(chart)) answer.hammer = await this.ask("mean", this.hammer, MEAN_OF);
    this.known.set(`${screen} ${place}`, answer);
    return answer;
  }

  /** Computes the other positions of a slider, nearest first, so that it reacts at once and its curve is complete. */
  async ahead(screen) {
    const { places, chart } = this.screens[screen], from = this.at[screen];
    const order = places.map((place, i) => [Math.abs(i - from), place]).sort(([a], [b]) => a - b);
    for (const [, place] of order) {
      if (screen !== this.screen || from !== this.at[screen] || !this.settled) return;
      if (this.known.has(`${screen} ${place}`)) continue;
      await this.answerAt(screen, place).catch(() => null);
      if (screen === this.screen && this.settled && ["feed", "rods"].includes(chart)) this.show();
    }
  }

  /** The known positions of this screen's slider, in order, with the engine's results. */
  get row() {
    return this.screens[this.screen].places.map((place) => [place,
        this.known.get(`${this.screen} ${place}`)]).filter(([, found]) => found);
  }

  /** The engine's results for a scene; it computes one scene at a time. */
  ask(kind, values, more = {}) {
    const key = kind + JSON.stringify(values);
    if (this.cache.has(key)) return this.cache.get(key);
    this.worker ??= this.engine((data) => this.heard(data), (text) => this.heard({ kind: "failed", text }));
    const answer = (this.last ?? Promise.resolve()).catch(() => 0).then(() => new Promise((resolve, reject) => {
      this.heard = (data) => {
        if (data.kind === "failed" || data.failure) return reject(new Error(data.text ?? data.failure));
        if (data.cycle) data.cycle.stress = data.cycle.stress.map((block) => samplesOf(block, data.cycle.time.length));
        resolve(data);
      };
      this.worker.postMessage({ kind, values, ...more });
    }));
    this.last = answer;
    this.cache.set(key, answer);
    return answer;
  }

  play(playing) {
    this.playing = playing;
    this.find("screen-play").textContent = say(playing ? "pause" : "play");
    if (!playing && this.answer) this.show();
  }

  /** Advances by so many of the viewer's seconds. */
  advance(seconds) {
    if (!this.playing || !this.answer?.cycle || !this.settled) return;
    const { screen } = this, { places } = this.screens[screen], timed = places.length === 201;
    const from = timed ? this.at[screen] / 200 : this.phase;
    this.phase = (from + (this.rest ?? 0) + seconds / PLAYED) % 1;
    this.rest = 0;
    if (timed) {
      const at = Math.floor(this.phase * 200);
      this.rest = this.phase - at / 200;
      if (at === this.at[screen]) return;
      Object.assign(this, { place: at });
      this.at[screen] = this.find("screen-handle").value = at;
      this.label();
    }
    this.draw();
  }

  show() {
    this.numbers = told(this, this.answer, this.place);
    const all = Object.fromEntries(Object.entries(this.numbers).map(([name, value]) => [name, digits(value, 3)]));
    const known = this.row.length, { places, chart } = this.screens[this.screen];
    const filling = chart === "feed" && known < places.length
        ? ` ${say("curve_filling", { known, all: places.length })}` : "";
    this.find("screen-text").textContent = say(`screen_${this.screen + 1}`, all) + filling;
    this.label();
    this.draw();
  }

  /** The instant that is shown, s. */
  get time() {
    const { screen, answer: { cycle }, place } = this, { moment, places } = this.screens[screen];
    return moment(cycle, places.length === 201 ? place : 200 * this.phase);
  }

  /** Writes the slider's position, and how much slower than real time it plays. */
  label() {
    const { find, screen, answer: { cycle }, place } = this, { moment, unit, scale = 1, places } = this.screens[screen];
    const timed = places.length === 201, most = moment && moment(cycle, 200) - cycle.impact;
    const number = timed ? (this.time - cycle.impact) * (unit === "ms" ? 1e3 : 1e6) : place * scale;
    const text = `${digits(number, 3)} ${unit}`.trim();
    find("screen-value").textContent = text;
    find("screen-handle").setAttribute("aria-valuetext", text);
    if (moment) find("screen-slowed").textContent = say("slowed",
        { times: written(Number((PLAYED / most).toPrecision(2)), { useGrouping: true }) });
  }

  draw() {
    if (!this.answer) return;
    const { find, answer: { values, cycle } } = this, { chart } = this.screens[this.screen];
    for (const place of this.figured.parentElement.children) place.hidden = place !== this.figured;
    if (chart) {
      this.figure[chart](this);
      return this.figure.canvas.show?.();
    }
    const scene = { get: (name) => this.value(name, values), variable: (name) => this.description.variables[name] };
    if (this.shown !== cycle) {
      this.picture.show(cycle, measure(scene, cycle),
          { gap: scene.get("contact.initial_gap"), diameter: scene.get("hole.diameter"),
          travel: scene.get("chuck.travel"), scale: SCALE });
      this.shown = cycle;
    }
    const { time } = this, index = cycle.time.findIndex((t) => t >= time);
    this.picture.draw(index < 0 ? cycle.time.length - 1 : index,
        this.screen === 2 ? (time - cycle.impact) * soundOf(values) : null);
    return this.picture.canvas.show?.();
  }

  /** Where this screen's figure is drawn. */
  get figured() {
    const { chart } = this.screens[this.screen];
    return this.find(`screen-${!chart ? "hammer" : chart in this.figure.plots ? chart : "chart"}`);
  }

  /** Saves the figure as it is shown: `kind` is png or svg. */
  save(kind) {
    const { chart } = this.screens[this.screen], plot = this.figure.plots[chart];
    const draw = (canvas) => (plot ? traced(plot, canvas) : drawnOn(chart ? this.figure : this.picture, canvas,
        () => this.draw()));
    saveFigure(`screen-${this.screen + 1}`, kind, this.figured, draw);
  }
}

const geometric = (from, to, steps) => Array.from({ length: steps },
    (_, i) => Number((from * (to / from) ** (i / (steps - 1))).toPrecision(3)));
