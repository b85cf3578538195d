// Part of the worker: the engine's long-run response of a scene (`dth_steady`, src/abi/browser.rs).

/** Relative error to which the mean rate is determined, and the largest number of simulated blows. */
const MEAN_ERROR = 0.01, MEAN_BLOWS = 1500;

TASKS.mean = ({ task, values, error = MEAN_ERROR, blows = MEAN_BLOWS }) => {
  let hammer;
  try {
    hammer = new Hammer(library, description, values);
    postMessage({ kind: "mean", task, ...longRun(hammer, error, blows) });
  } catch (error) {
    // A scene that fails is a gap in the curve, not its end.
    postMessage({ kind: "mean", task, failure: error.message });
  } finally {
    hammer?.free();
    library.take();
  }
};

/** Returns the kind of response, the number of blows, and for each name its mean, standard error and spread. */
function longRun(hammer, error, most) {
  const { room, functions } = library;
  const names = library.string(functions.dth_steady_names()).trim().split("\n");
  hammer.do("dth_steady", error, most, room + VALUES);
  const numbers = new Float64Array(functions.memory.buffer, room + VALUES, 3 + 3 * names.length);
  const [returns, blows, reached] = numbers;
  const kind = returns > 0 ? "cycle" : returns < 0 ? "stalled" : "irregular";
  const list = (from) => record(names, numbers.slice(3 + from * names.length));
  return { response: kind, returns, blows, reached: reached === 1, mean: list(0), error: list(1), spread: list(2) };
}
