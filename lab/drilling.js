// Part of the worker: drills a hole through layers, with set points that change on the way.

/** Between looks at the hole, s: shorter than a blow period. */
const STRIDE = 0.01;
/** Without progress for so long a hammer does not drill, s. */
const STUCK = 5;
const OF_HOLE = ["drilled_length", "blow_count", "blow_energy", "rock_force_peak"];

/** The hole in work. */
let hole = null;

/** Begins a hole: layers from the top, each with the depth of its bottom (m) and the rock's values;
 * a row of the log every so many metres; at most `pace` seconds of drilling in one of the viewer. */
TASKS.drill = async ({ hole: number, values, layers, every, pace }) => {
  hole?.hammer?.free();
  library.take();
  const hammer = new Hammer(library, description, { ...values, ...layers[0].values });
  const mine = { number, layers, every, pace, hammer, rows: [], settings: [], pending: {} };
  hole = Object.assign(mine, { layer: 0, depth: 0, blows: 0, moved: 0, row: begun(0, 0, 0) });
  mine.clock = [performance.now(), 0];
  let [done, told] = [false, 0];
  while (!done) {
    const listened = performance.now(), until = mine.clock[1] + (mine.pace * (listened - mine.clock[0])) / 1000;
    while (!done && hammer.time < until && performance.now() - listened < PATIENCE) done = stride(mine);
    if (done || listened - told > 100) {
      told = listened;
      tellHole(mine, done);
    }
    await new Promise((next) => setTimeout(next, hammer.time < until ? 0 : 10));
    if (mine !== hole) return;
  }
  hammer.free();
  mine.hammer = null;
};

/** New set points, which act from the next stride on, or another pace. */
TASKS.tune = ({ values, pace }) => {
  if (!hole?.hammer) return;
  Object.assign(hole.pending, values);
  // The clock starts again: what has been drilled keeps its time.
  if (pace) Object.assign(hole, { pace, clock: [performance.now(), hole.hammer.time] });
};

TASKS.stop = () => {
  hole?.hammer?.free();
  hole = null;
};

/** Drills on a little; true if the hole is as deep as the layers, or nothing moves any more. */
function stride(mine) {
  const { hammer, layers, row } = mine;
  retune(mine);
  hammer.advance(hammer.time + STRIDE);
  const [depth, blows, energy, peak] = hammer.reals(references(OF_HOLE));
  if (depth > mine.depth) mine.moved = hammer.time;
  if (blows > mine.blows) row.energies.push(energy);
  row.peak = Math.max(row.peak, peak);
  Object.assign(mine, { depth, blows });
  const { bottom } = layers[mine.layer];
  if (depth >= row.depth + mine.every || depth >= bottom) finish(mine);
  if (depth < bottom) return hammer.time - mine.moved > STUCK;
  mine.layer += 1;
  if (mine.layer < layers.length) Object.assign(mine.pending, layers[mine.layer].values);
  return mine.layer === layers.length;
}

/** Sets what has changed. */
function retune(mine) {
  if (Object.keys(mine.pending).length === 0) return;
  mine.hammer.set(mine.pending);
  mine.settings.push([mine.hammer.time, mine.pending]);
  mine.pending = {};
}

/** Adds a row to the log, of what happened since the row before, and begins the next. */
function finish(mine) {
  const { hammer, row, depth, blows, layer } = mine;
  const took = hammer.time - row.time, count = row.energies.length;
  const energy = row.energies.reduce((sum, each) => sum + each, 0) / count;
  const [rate, frequency] = [(depth - row.depth) / took, (blows - row.blows) / took];
  mine.rows.push({ time: hammer.time, depth, layer, rate, frequency, energy, peak: row.peak });
  mine.row = begun(hammer.time, depth, blows);
}

const begun = (time, depth, blows) => ({ time, depth, blows, energies: [], peak: 0 });

function tellHole(mine, done) {
  const { number, rows, settings, depth, layers, hammer } = mine;
  const stuck = done && depth < layers.at(-1).bottom;
  postMessage({ kind: "hole", hole: number, rows, settings, depth, layer: mine.layer, time: hammer.time, done, stuck });
}
