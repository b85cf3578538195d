// Part of the worker: a hammer in its casing is lifted off the rock and pressed back.

/** For how long it is lifted, held, let down, and pressed on again, s. */
const HOISTED = [0.1, 0.8, 0.1, 0.25];
/** How much further than the bit can hang out it is lifted, m. */
const CLEAR = 0.01;
/** The hoist is a spring with critical damping on the casing's `mass`, of this angular frequency, 1/s.
 * Its force is the feed, set at every look. */
const HOIST = 60;

TASKS.lift = ({ scene, mass }) => {
  const { hammer, rows, values } = present;
  if (scene !== present.scene || rows.length < 2) return;
  const value = (name) => values[name] ?? description.variables[name].start;
  const [place, speed] = references(["casing_position", "casing_velocity"]).map((each) => () => hammer.reals([each])[0]);
  const now = hammer.keep(), begun = hammer.time, rest = place();
  const [up, held, down] = HOISTED, height = value("chuck.travel") + CLEAR, stiffness = mass * HOIST ** 2;
  const samples = new Samples(hammer, values);
  samples.take();
  try {
    const [end, period] = [up + held + down, HOISTED.reduce((sum, each) => sum + each)];
    for (let time = LOOK; time < period; time += LOOK) {
      const lifted = height * Math.max(0, Math.min(1, time / up, (end - time) / down));
      const pull = stiffness * (lifted + place() - rest) + (2 * stiffness * speed()) / HOIST;
      hammer.set({ feed_force: time < end ? -pull : value("feed_force") });
      samples.follow(begun + time, () => LOOK, ROUGH * FINE);
    }
    postMessage({ kind: "cycle", scene, blow: rows.length - 2, lifted: true, impact: begun, period, outlook: OUTLOOK, ...samples.all() });
  } finally {
    hammer.restore(now);
    hammer.forget(now);
  }
};
