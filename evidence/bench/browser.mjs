// What `hammer/examples/runs.rs` does, by the library of the laboratory's page in node:
//
//     node evidence/bench/browser.mjs target/.../dth_hammer.wasm 20 rock
//
// makes 20 runs of 1 s, each in another rock. The words are those of the example, without those of
// gradients, steps and vectors.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";

const [wasm, count, ...words] = process.argv.slice(2);
const of = (path) => readFileSync(new URL(`../../${path}`, import.meta.url), "utf8");
// The page's own scripts, which are no modules.
const scripts = ["lab/engine.js", "lab/means.js"].map(of).join("\n");
const page = "const record = (names, numbers) => Object.fromEntries(names.map((n, i) => [n, numbers[i]]));"
  + " ({ Library, Hammer, longRun, use: (one) => { library = one; } })";
const { Library, Hammer, longRun, use } = runInThisContext(`const TASKS = {}; let library; ${scripts}\n${page}`);
const library = new Library(readFileSync(wasm));
use(library);

/** The same as the page reads of the description. */
const xml = of("modelDescription.xml");
const variables = Object.fromEntries(
  [...xml.matchAll(/<ScalarVariable name="([^"]+)" valueReference="(\d+)"[^>]*>\s*<(\w+)[^>]*?(?: start="([^"]+)")?\/>/g)]
    .map(([, name, reference, type, start]) => [name, { reference: Number(reference), type, start: Number(start) }]),
);
const description = { guid: xml.match(/guid="([^"]+)"/)[1], variables };
const read = (hammer, name) => hammer.reals([variables[name].reference])[0];

const varied = [], values = {};
const actions = {
  run(hammer) {
    hammer.advance(1.0);
    return read(hammer, "tip_depth");
  },
  start(hammer) {
    while (read(hammer, "blow_count") < first) hammer.advance(hammer.time + 1e-3);
    return hammer.time;
  },
  mean: (hammer) => longRun(hammer).mean.rop,
};
let action = actions.run, first = 0;
for (const word of words) {
  const [name, value] = word.split("=");
  if (name === "rock") varied.push("rock.stiffness");
  else if (name === "feed") varied.push("feed_force");
  else if (name === "first") [first, action] = [Number(value), actions.start];
  else if (name in actions) action = actions[name];
  else if (name === "rigid") values.fidelity = 1;
  else if (name === "elements") values["piston.elements"] = values["bit.elements"] = Number(value);
  else if (value !== undefined && name in variables) values[name] = Number(value);
  else throw new Error(`${word}: no such word`);
}

let sum = 0;
for (let i = 0; i < Number(count); i += 1) {
  const own = { ...values };
  for (const name of varied) own[name] = variables[name].start * (1 + 1e-3 * i);
  const hammer = new Hammer(library, description, own);
  sum += action(hammer);
  hammer.free();
}
console.log(`wasm ${sum.toExponential(15)}`);
