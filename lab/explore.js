// The explanation: eight screens, each with one figure and one handle. What a text predicts is worked out
// here from the scene; what it compares with is the engine's.

/** Mass of the casing where the feed is looked at, kg. */
const CASING = 25;
/** One blow on a drill string: a piston that arrives at this speed, m/s, from a small gap, m. On this mesh the share that
 * the rock gets is within 2 % of that on five times as many spans, with up to four rods. */
const STRIKE = { "piston.initial_velocity": 10, "contact.initial_gap": 1e-4, "contact.stiffness": 1e10, "mesh.degree": 5, "piston.elements": 20, "bit.elements": 40 };
/** Forces are read here, which the preset's mesh is not made for: `dth-hammer mesh water_hammer --of force --error 1%`. */
const FORCE_MESH = { "mesh.degree": 5, "piston.elements": 44, "bit.elements": 23 };
const GEOMETRIC = (from, to, steps) => Array.from({ length: steps }, (_, i) => Number((from * (to / from) ** (i / (steps - 1))).toPrecision(3)));

class Explore {
  /** `engine` makes a worker; `presets` are the scenes to start from; `scene` reads a variable. */
  constructor(find, engine, description, presets) {
    Object.assign(this, { find, engine, description, screen: 0, cache: new Map(), settled: false, numbers: {} });
    this.hammer = { ...presets.water_hammer.start_values, ...FORCE_MESH };
    this.drifter = { ...presets.top_hammer.start_values, ...STRIKE };
    this.picture = new Picture(find("screen-hammer"));
    this.pen = find("screen-chart").getContext("2d");
    const moments = Array.from({ length: 201 }, (_, i) => i);
    const feeds = GEOMETRIC(2400, 17000, 9), forces = GEOMETRIC(3750, 15000, 9), stiff = GEOMETRIC(0.25, 4, 9);
    const [easy, hard] = this.rocks(), rocks = GEOMETRIC(easy, hard, 19);
    const plain = () => this.hammer;
    /** Of each screen: places of the handle, the one to begin with, how it is written, the scene at one. */
    this.screens = [
      { places: moments, begin: 60, scene: plain, moment: (c, at) => c.impact - 0.3 * c.period + 1.3 * c.period * (at / 200), unit: "ms" },
      { places: forces, begin: 4, scene: (force) => ({ ...this.hammer, "drive.amplitude": force }), unit: "kN", moment: (c) => c.impact + 0.75 * c.period },
      { places: moments, begin: 40, scene: plain, moment: (c, at) => c.impact + 1e-6 * at, unit: "µs" },
      { places: moments, begin: 120, scene: plain, moment: (c, at) => c.impact + 5e-6 * at, chart: "loop", unit: "µs" },
      { places: rocks, begin: 9, scene: (energy) => ({ ...this.hammer, "rock.specific_energy": energy }), chart: "hole", unit: "MJ/m³" },
      { places: stiff, begin: 8, scene: (times) => ({ ...this.hammer, "rock.stiffness": times * this.value("rock.stiffness") }), chart: "loop", ghost: 4, unit: "×" },
      { places: feeds, begin: 6, scene: (feed) => ({ ...this.hammer, "casing.mass": CASING, feed_force: feed }), unit: "kN", moment: (c) => c.impact + 3e-4 },
      { places: [0, 1, 2, 3, 4], begin: 4, scene: (rods) => ({ ...this.drifter, "drill.rods": rods }), chart: "rods", unit: "" },
    ];
    this.at = this.screens.map(({ begin }) => begin);
    find("screen-handle").addEventListener("input", ({ target }) => this.move(target.valueAsNumber));
    find("screen-back").addEventListener("click", () => this.go(this.screen - 1));
    find("screen-next").addEventListener("click", () => this.go(this.screen + 1));
  }

  value(name, values = this.hammer) {
    return values[name] ?? this.description.variables[name].start;
  }

  /** The least and the most work to break a volume of rock that is possible where nothing is known, J/m³. */
  rocks() {
    const [energy, factor] = ["rock.specific_energy", "rock.specific_energy_factor"].map((name) => this.value(name));
    return [energy / factor, energy * factor];
  }

  go(screen) {
    const { find } = this;
    if (screen >= this.screens.length) return (location.hash = "laboratory");
    this.screen = Math.max(0, screen);
    history.replaceState(null, "", `#screen=${this.screen + 1}`);
    const { places } = this.screens[this.screen], number = this.screen + 1;
    find("screen-title").textContent = say("screen_step", { step: number, all: this.screens.length, title: say(`screen_${number}_title`) });
    find("screen-label").textContent = say(`screen_${number}_handle`);
    Object.assign(find("screen-handle"), { min: 0, max: places.length - 1, value: this.at[this.screen] });
    find("screen-back").disabled = this.screen === 0;
    find("screen-next").textContent = say(`screen_${number}_next`);
    for (const id of ["screen-text", "screen-value"]) find(id).textContent = "";
    return this.move(this.at[this.screen]);
  }

  async move(at) {
    this.at[this.screen] = at;
    this.settled = false;
    const { screen } = this, { places, scene, chart, ghost } = this.screens[screen];
    const rods = chart === "rods", values = scene(places[at]);
    try {
      const found = await this.ask(values, rods), other = await this.ask(rods ? scene(0) : scene(places[ghost ?? at]), rods);
      if (screen !== this.screen || at !== this.at[screen]) return;
      Object.assign(this, { found, other, values, place: places[at] });
      this.show();
    } catch (error) {
      this.find("screen-text").textContent = say("screen_failed");
      this.failure = error.message;
    }
    this.settled = true;
  }

  /** What the engine says of a scene; it is asked one scene at a time. */
  ask(values, strike) {
    const key = JSON.stringify(values);
    if (this.cache.has(key)) return this.cache.get(key);
    const task = strike ? { kind: "strike", until: (2 * values["drill.rods"] + 3) * 1e-3 } : { kind: "explore" };
    this.worker ??= this.engine((data) => this.heard(data), (text) => this.heard({ kind: "failed", text }));
    const answer = (this.last ?? Promise.resolve()).catch(() => 0).then(() => new Promise((resolve, reject) => {
      this.heard = (data) => {
        if (data.kind === "failed") return reject(new Error(data.text));
        if (data.cycle) data.cycle.stress = data.cycle.stress.map((block) => samplesOf(block, data.cycle.time.length));
        resolve(data);
      };
      this.worker.postMessage({ ...task, ask: key, values });
    }));
    this.last = answer;
    this.cache.set(key, answer);
    return answer;
  }

  show() {
    const { find } = this, number = this.screen + 1, { chart, unit, moment } = this.screens[this.screen];
    this.numbers = chart === "rods" ? this.ofRods() : this.ofCycle();
    const scale = { kN: 1e-3, "MJ/m³": 1e-6 }[unit] ?? 1, { cycle } = this.found;
    const time = moment && cycle && ["ms", "µs"].includes(unit) ? (moment(cycle, this.place) - cycle.impact) * (unit === "ms" ? 1e3 : 1e6) : null;
    const text = `${digits(time ?? this.place * scale, 3)} ${unit}`.trim();
    find("screen-value").textContent = text;
    find("screen-handle").setAttribute("aria-valuetext", text);
    find("screen-text").textContent = say(`screen_${number}`, Object.fromEntries(Object.entries(this.numbers).map(([name, value]) => [name, digits(value, 3)])));
    this.draw();
  }

  /** What the texts of the first seven screens say, in the units that they say it in. */
  ofCycle() {
    const { values } = this, { rows, cycle } = this.found, of = (name) => this.value(name, values), blow = rows.at(-1);
    const first = cycle.time.findIndex((time) => time >= cycle.impact), end = cycle.time.findLastIndex((time) => time <= cycle.impact + cycle.period);
    const over = (name, c = cycle, [from, to] = [first, end]) => c[name][to] - c[name][from];
    const density = of("material.density"), wave = Math.sqrt(of("material.youngs_modulus") / density);
    const sections = BODIES.map((body) => Array.from({ length: of(`${body}.segments`) }, (_, i) => ["length", "area"].map((size) => of(`${body}.segment[${i + 1}].${size}`))));
    const mass = sections[0].reduce((sum, [length, area]) => sum + length * area, 0) * density;
    const [upper, lower] = [sections[0].at(-1)[1], sections[1][0][1]], long = sections[1].reduce((sum, [length]) => sum + length, 0);
    const after = (time) => cycle.time.findIndex((t) => t >= cycle.impact + time);
    const work = over("energy_rock_dissipated") + over("energy_viscous"), area = (Math.PI / 4) * of("hole.diameter") ** 2;
    // Of this blow: the samples end a little after the next.
    const depth = ({ cycle: c }) => {
      const ends = [c.time.findIndex((t) => t >= c.impact), c.time.findLastIndex((t) => t < c.impact + c.period)];
      return Math.max(...c.bit_tip_position.slice(...ends)) - c.bit_tip_position[ends[0]];
    };
    const workOf = ({ cycle: c }) => {
      const ends = [c.time.findIndex((t) => t >= c.impact), c.time.findLastIndex((t) => t <= c.impact + c.period)];
      return over("energy_rock_dissipated", c, ends) + over("energy_viscous", c, ends);
    };
    let loop = 0;
    for (let i = first; i < end; i++) loop += 0.5 * (cycle.rock_force[i] + cycle.rock_force[i + 1]) * (cycle.bit_tip_position[i + 1] - cycle.bit_tip_position[i]);
    const times = 1 / blow.blow_period, perMetre = area * of("rock.specific_energy"), rate = (energy) => (3600 * work * times) / (area * energy);
    const [easy, hard] = this.rocks(), twoDigits = (number) => Number(number.toPrecision(2));
    const stiffer = of("rock.stiffness") / this.value("rock.stiffness");
    const rises = cycle.rock_force.findIndex((force, i) => i > first && force > cycle.rock_force[first] + 1e4);
    return {
      mass, speed: blow.blow_speed, energy: blow.blow_energy, times, height: blow.blow_speed ** 2 / (2 * of("gravity")),
      rise: 1e3 * (cycle.piston_position[first] - Math.min(...cycle.piston_position)),
      drive: 1e-3 * of("drive.amplitude"), stroke: 1e3 * of("drive.stroke"), given: 2 * of("drive.amplitude") * of("drive.stroke"), taken: over("energy_drive"),
      wave, shock: 1e-3 * blow.blow_speed * density * wave * ((upper * lower) / (upper + lower)), contact: 1e-3 * cycle.contact_force[after(2e-5)],
      long: 1e3 * long, arrives: (1e6 * long) / wave, felt: 1e6 * (cycle.time[rises] - cycle.impact),
      loop, work, share: (100 * work) / blow.blow_energy, steeper: of("rock.unloading_ratio"), power: 1e-3 * work * times,
      diameter: 1e3 * of("hole.diameter"), specific: 1e-6 * of("rock.specific_energy"), metre: 1e-6 * perMetre,
      predicted: rate(of("rock.specific_energy")), rate: 3600 * blow.rop, low: rate(hard), high: rate(easy), hard: twoDigits(1e-6 * hard), easy: twoDigits(1e-6 * easy),
      stiffer, depth: 1e3 * depth(this.found), before: 1e3 * depth(this.other), root: (1e3 * depth(this.other)) / Math.sqrt(stiffer),
      peak: 1e-3 * Math.max(...cycle.rock_force), peak_before: 1e-3 * Math.max(...this.other.cycle.rock_force), work_before: workOf(this.other),
      feed: 1e-3 * of("feed_force"), weight: 1e-3 * CASING * of("gravity"), least: 1e-3 * (of("drive.amplitude") - CASING * of("gravity")),
    };
  }

  ofRods() {
    const { values, found, other } = this, rods = values["drill.rods"], of = (name) => this.value(name, values);
    const bit = of("bit.segment[1].length") + of("bit.segment[2].length");
    const long = bit + (rods ? of("drill.shank.length") + rods * of("drill.rod.length") : 0);
    const wave = Math.sqrt(of("material.youngs_modulus") / of("material.density"));
    return { rods, long, wave, arrives: (1e3 * long) / wave, felt: 1e3 * found.arrival, share: 100 * found.share, straight: 100 * other.share };
  }

  draw() {
    if (!this.found) return;
    const { chart, moment } = this.screens[this.screen], { cycle } = this.found, { find } = this;
    find("screen-hammer").hidden = Boolean(chart);
    find("screen-chart").hidden = !chart;
    if (!chart) {
      const scene = { get: (name) => this.value(name, this.values), variable: (name) => this.description.variables[name] };
      const travel = this.values["casing.mass"] ? scene.get("chuck.travel") : 0;
      this.picture.show(cycle, measure(scene, cycle), { gap: scene.get("contact.initial_gap"), diameter: scene.get("hole.diameter"), travel });
      const time = moment(cycle, this.place), index = cycle.time.findIndex((t) => t >= time);
      this.picture.draw(index < 0 ? cycle.time.length - 1 : index);
      return;
    }
    const [width, height] = fit(find("screen-chart"));
    this.pen.clearRect(0, 0, width, height);
    const frame = { left: 56, right: width - 12, top: 14, bottom: height - 44 };
    if (chart === "loop") this.loop(frame);
    if (chart === "hole") this.bars(frame, [["low", this.numbers.low], ["now", this.numbers.rate], ["high", this.numbers.high]], say("rate_axis"));
    if (chart === "rods") this.bars(frame, [["without_rods", this.numbers.straight], ["now", this.numbers.share]], say("share_axis"), 100);
  }

  /** Axes from 0 to the largest values; returns where numbers are drawn. */
  axes({ left, right, top, bottom }, [most, highest], [below, beside]) {
    const { pen } = this, x = (v) => left + (v / most) * (right - left), y = (v) => bottom - (v / highest) * (bottom - top);
    pen.font = "12px system-ui, sans-serif";
    Object.assign(pen, { fillStyle: palette.ink, strokeStyle: palette.grid, lineWidth: 1, textBaseline: "middle" });
    for (let i = 0; i <= 4; i++) {
      const value = (i / 4) * highest;
      pen.beginPath();
      pen.moveTo(left, y(value));
      pen.lineTo(right, y(value));
      pen.stroke();
      pen.textAlign = "right";
      pen.fillText(digits(value, 3), left - 5, y(value));
      pen.textAlign = "center";
      if (below) pen.fillText(digits((i / 4) * most, 3), Math.min(right - 8, x((i / 4) * most)), bottom + 12);
    }
    if (below) pen.fillText(below, 0.5 * (left + right), bottom + 32);
    pen.save();
    pen.translate(12, 0.5 * (top + bottom));
    pen.rotate(-Math.PI / 2);
    pen.fillText(beside, 0, 0);
    pen.restore();
    return [x, y];
  }

  /** Force against depth of the tip, of the scene and, grey, of the one it is compared with. */
  loop(frame) {
    const { pen } = this, { chart: _, ghost, moment } = this.screens[this.screen], sets = ghost === undefined ? [this.found] : [this.other, this.found];
    const lists = sets.map(({ cycle: c }) => {
      const first = c.time.findIndex((t) => t >= c.impact), last = c.time.findLastIndex((t) => t <= c.impact + 2e-3);
      return Array.from({ length: last - first }, (_, i) => [1e3 * (c.bit_tip_position[first + i] - c.bit_tip_position[first]), 1e-3 * c.rock_force[first + i], c.time[first + i]]);
    });
    const most = [0, 1].map((i) => rounded(Math.max(...lists.flat().map((point) => point[i]))));
    const [x, y] = this.axes(frame, most, [say("depth_axis_short"), say("force_axis")]);
    lists.forEach((list, i) => {
      Object.assign(pen, { strokeStyle: i === lists.length - 1 ? palette.rock : palette.ghost, lineWidth: 2.5 });
      pen.beginPath();
      list.forEach(([depth, force]) => pen.lineTo(x(Math.max(0, depth)), y(force)));
      pen.stroke();
    });
    if (!moment) return;
    const time = moment(this.found.cycle, this.place), [depth, force] = lists.at(-1).findLast((point) => point[2] <= time) ?? lists.at(-1)[0];
    pen.fillStyle = palette.ink;
    pen.beginPath();
    pen.arc(x(Math.max(0, depth)), y(force), 6, 0, 2 * Math.PI);
    pen.fill();
  }

  bars(frame, rows, label, most = rounded(Math.max(...rows.map(([, value]) => value)))) {
    const { pen } = this, [, y] = this.axes(frame, [1, most], ["", label]), each = (frame.right - frame.left) / rows.length;
    rows.forEach(([name, value], i) => {
      const left = frame.left + (i + 0.2) * each;
      pen.fillStyle = name === "now" ? palette.piston : palette.ghost;
      pen.fillRect(left, y(value), 0.6 * each, frame.bottom - y(value));
      Object.assign(pen, { fillStyle: palette.ink, textAlign: "center" });
      pen.fillText(digits(value, 3), left + 0.3 * each, y(value) - 9);
      pen.fillText(say(`bar_${name}`), left + 0.3 * each, frame.bottom + 14, each);
    });
  }
}
