// The worker runs scenes, so that the page stays responsive however long a scene takes.

/** A scene ends after so many blows, or so many seconds. */
const MOST_BLOWS = 30, LONGEST = 4;
/** Time between readings of the number of blows, s: shorter than any blow period worth showing. */
const LOOK = 1e-3;
/** Distance of samples: while waves run (s), after an impact (s), in flight (over the period). */
const FINE = 2e-6, MEDIUM = 1e-5, COARSE = 1 / 400;
/** By this factor samples of the first cycle are farther apart, because the settled cycle soon replaces it. */
const ROUGH = 4;
/** How long waves run after a collision, and how long the time after an impact is, s. */
const WAVES = 6e-4, OUTLOOK = 4e-3;
/** Samples beyond which a cycle is cut off. */
const MOST_SAMPLES = 20000;
/** How long the worker computes before it reads messages, and before it reports its progress, ms. */
const PATIENCE = 15, REPORT = 100;

const OF_BLOW = ["blow_time", "blow_speed", "blow_energy", "blow_period", "blow_penetration", "rop", "tip_rate",
    "air_flow"];
const OF_MOTION = [
  "piston_position", "bit_position", "bit_tip_position", "tip_depth",
  "piston_velocity", "bit_velocity", "contact_force", "rock_force", "casing_position", "chuck_force",
  "relative_position", "applied_drive_force", "drive_chamber_pressure", "return_chamber_pressure",
  "energy_drive", "energy_rock_dissipated", "energy_viscous", "contact_count",
];

const BODIES = ["piston", "bit"];

/** Functions of the worker's other files, by the kind of message that calls them. */
const TASKS = {};

let library, description;
/** The running scene: its number, its hammer, its blows and a state shortly before each. */
let present = { scene: 0, hammer: null, rows: [], before: [] };

onmessage = async ({ data }) => {
  try {
    if (data.kind === "open") [library, description] = [new Library(data.bytes), data.description];
    else if (data.kind === "bits") postMessage({ kind: "bits", lines: bits(data) });
    else if (data.kind === "datasheet") postMessage({ kind: "datasheet", text: library.datasheet(data.request) });
    else if (data.kind === "run") await run(data);
    else if (TASKS[data.kind]) await TASKS[data.kind](data);
    else if (data.scene === present.scene) cycle(data.blow);
  } catch (error) {
    postMessage({ kind: "failed", scene: data.scene, text: error.message });
  }
};

function references(names) {
  return names.map((name) => description.variables[name].reference);
}

function record(names, numbers) {
  return Object.fromEntries(names.map((name, i) => [name, numbers[i]]));
}

/** Drops the running scene and begins another. */
function begin(scene, values) {
  present.before.forEach((state) => present.hammer.forget(state));
  present.hammer?.free();
  present = { scene, hammer: null, rows: [], before: [] };
  library.take();
  present.hammer = new Hammer(library, description, values);
  present.warnings = library.take();
  return present;
}

/** Runs a scene from rest, blow by blow, until another takes its place. */
async function run({ scene, values }) {
  const mine = begin(scene, values);
  const { hammer, rows, before, warnings } = mine;
  const count = references(["blow_count"]), row = references(OF_BLOW);
  const stalled = references(["stalled"]);
  const tell = (done) => {
    const stands = hammer.integers(stalled, "fmi2GetBoolean")[0] === 1;
    postMessage({ kind: "blows", scene, rows, time: hammer.time, stalled: stands, warnings, done });
  };
  // A still picture is sent before the hammer moves.
  const still = new Samples(hammer);
  still.take();
  postMessage({ kind: "cycle", scene, blow: -1, impact: 0, period: 0, outlook: OUTLOOK, ...still.all() });
  // Two earlier states, since a cycle is shown from shortly before its impact.
  let [older, newer] = [null, hammer.keep()];
  let listened = performance.now(), reported = listened;
  for (let look = 1; rows.length < MOST_BLOWS && look * LOOK <= LONGEST; look++) {
    const spare = older;
    older = newer;
    newer = hammer.keep(spare?.[0]);
    hammer.advance(look * LOOK);
    if (hammer.reals(count)[0] > rows.length) {
      rows.push(record(OF_BLOW, hammer.reals(row)));
      before.push(older);
      older = null;
      // The first cycle is shown at once, while the rest settles.
      if (rows.length === 2) cycle(0, { rough: ROUGH });
    }
    if (performance.now() - listened > PATIENCE) {
      if (performance.now() - reported > REPORT) {
        tell(false);
        reported = performance.now();
      }
      await new Promise((done) => setTimeout(done));
      if (mine !== present) return;
      listened = performance.now();
    }
  }
  [older, newer].forEach((state) => state && hammer.forget(state));
  tell(true);
  if (rows.length > 2) cycle(rows.length - 2, { last: true });
}

/** Posts samples from one blow to the next, with the stresses along both bodies, `rough` times as far apart. */
function cycle(blow, { last = false, rough = 1 } = {}) {
  const { hammer, rows, before, scene } = present;
  if (rows[blow + 1] === undefined) return;
  const impact = rows[blow].blow_time, period = rows[blow + 1].blow_time - impact;
  const now = hammer.keep();
  hammer.restore(before[blow]);
  const sampled = sample(hammer, impact, period, rough);
  hammer.restore(now);
  hammer.forget(now);
  postMessage({ kind: "cycle", scene, blow, last, ...sampled });
}

/** Samples a cycle from the present instant on, which is shortly before its impact. */
function sample(hammer, impact, period, rough = 1) {
  const samples = new Samples(hammer);
  samples.take();
  const close = (time) => time >= impact - 10 * MEDIUM && time < impact + OUTLOOK;
  samples.follow(impact + 1.03 * period, (time) => rough * (close(time) ? MEDIUM : COARSE * period), rough * FINE);
  return { impact, period, outlook: OUTLOOK, ...samples.all() };
}

/** The samples of a cycle. */
class Samples {
  constructor(hammer) {
    this.hammer = hammer;
    this.motion = references(OF_MOTION);
    [this.mode, this.closed] = [references(["rock_mode"]), references(["contact_closed"])];
    this.count = references(["contact_count"]);
    this.times = [];
    this.rows = [];
    this.stresses = [[], []];
    this.modes = [];
    this.contacts = 0;
    /** The instant at which the waves of a collision end, s. */
    this.waves = -Infinity;
  }

  take() {
    const { hammer } = this;
    const row = hammer.reals(this.motion);
    this.contacts = row[row.length - 1];
    this.times.push(hammer.time);
    this.rows.push(row);
    this.modes.push([hammer.integers(this.mode)[0], hammer.integers(this.closed, "fmi2GetBoolean")[0]]);
    this.stresses.forEach((rows, body) => rows.push(hammer.stress(body)));
  }

  /** Takes samples until a time, in steps of `step(time)`, and of `fine` while waves run. */
  follow(until, step, fine) {
    const { hammer } = this;
    // Sums of steps differ from the end by rounding.
    while (hammer.time < until - 1e-9 && this.times.length < MOST_SAMPLES) {
      const waves = hammer.time < this.waves;
      const back = waves ? null : hammer.keep();
      hammer.advance(hammer.time + (waves ? fine : step(hammer.time)));
      // A collision within a longer step is simulated again in short steps.
      if (back && hammer.reals(this.count)[0] > this.contacts) {
        this.waves = hammer.time + WAVES;
        hammer.restore(back);
      } else {
        this.take();
      }
      if (back) hammer.forget(back);
    }
  }

  all() {
    const column = (i) => Float64Array.from(this.rows, (row) => row[i]);
    return {
      time: Float64Array.from(this.times),
      ...Object.fromEntries(OF_MOTION.map((name, i) => [name, column(i)])),
      rock_mode: Int32Array.from(this.modes, ([mode]) => mode),
      contact_closed: Int32Array.from(this.modes, ([, closed]) => closed),
      stress: this.stresses.map(block),
    };
  }
}

/** Joins rows of equal length into one array, because thousands of small arrays take long to send. */
function block(rows) {
  const all = new Float64Array(rows.length * rows[0].length);
  rows.forEach((row, i) => all.set(row, i * row.length));
  return all;
}

/** The named outputs at equal steps, as bits: one line of hexadecimal numbers per point. */
function bits({ values, step, steps, names }) {
  const hammer = new Hammer(library, description, values);
  const wanted = references(names);
  const line = () => {
    const words = new BigUint64Array(hammer.reals(wanted).buffer);
    return Array.from(words, (word) => word.toString(16).padStart(16, "0")).join(" ");
  };
  try {
    const lines = [line()];
    for (let i = 0; i < steps; i++) {
      hammer.do("fmi2DoStep", i * step, step, 0);
      lines.push(line());
    }
    return lines;
  } finally {
    hammer.free();
  }
}
