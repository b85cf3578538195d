// Part of the worker: computations for the screens of the explanation.

/** Blows after which a scene counts as settled here. */
const EXPLORED = 10;

/** The last whole cycle of a scene after some blows from rest, and the rows of its blows. */
TASKS.explore = ({ ask, values }) => {
  library.take();
  const hammer = new Hammer(library, description, values), rows = [];
  const [count, row] = [references(["blow_count"]), references(OF_BLOW)];
  let before = null;
  try {
    for (let look = 1; rows.length < EXPLORED && look * LOOK <= LONGEST; look++) {
      const state = hammer.keep();
      hammer.advance(look * LOOK);
      const struck = hammer.reals(count)[0] > rows.length;
      if (struck) rows.push(record(OF_BLOW, hammer.reals(row)));
      if (struck && rows.length === EXPLORED - 1) before = state;
      else hammer.forget(state);
    }
    if (rows.length < EXPLORED) throw new Error(`${rows.length} blows in ${LONGEST} s`);
    const impact = rows.at(-2).blow_time, period = rows.at(-1).blow_time - impact;
    hammer.restore(before);
    postMessage({ kind: "explored", ask, rows, cycle: sample(hammer, impact, period) });
  } finally {
    hammer.free();
  }
};
