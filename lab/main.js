// The page: sliders change the scene, the worker runs it, and the results are drawn.

const find = (id) => document.getElementById(id);
const description = readDescription(find("description").textContent);
const scene = new Scene(description, JSON.parse(find("presets").textContent));

/** How long a slider rests before its scene is run, ms. */
const REST = 60;
/** Time without a message from the worker after which it is replaced, ms. */
const LOST = 20000;

let number = 0, waiting = null, watchdog = null, blows = [], worker = null;
fillTexts(find);
readPalette();
const drawing = new Picture(find("hammer"), { curve: true });
const player = new Player();
const charts = new Charts(find);
const waves = new WaveDiagram(find("waves"), find("wave-text"), pointAt);
const past = new Past(scene, find, go);
const controls = new Map();
const sheet = new DatasheetForm(JSON.parse(find("choices").textContent), scene, find, ask);
/** The state of the page, for tests and other scripts. */
const laboratory = { settled: false, frames: 0, blows: [], cycle: null, ask: null, sheet: null };
window.laboratory = laboratory;

/** Loads the scene of a link. */
function go(link) {
  scene.follow(link);
  renew();
}

function change(name, value) {
  if (scene.set(name, value)) renew();
  else controls.get(name)();
}

/** Shows the present scene, and runs it as soon as the sliders rest. */
function renew() {
  controls.forEach((show) => show());
  const preset = scene.preset();
  const [nearest] = scene.nearest();
  find("own").textContent = nearest ? say("changed", { preset: nearest.replaceAll("_", " ") }) : say("your_own");
  find("preset").value = preset ?? "";
  find("preset-text").textContent = preset ? scene.presets[preset].description : "";
  find("command").textContent = scene.command();
  try {
    history.replaceState(null, "", `#${scene.link() || "laboratory"}`);
  } catch {
    location.hash = scene.link() || "laboratory";
  }
  // From here on, messages of the worker about the previous scene are ignored.
  number += 1;
  laboratory.settled = false;
  past.note();
  clearTimeout(waiting);
  waiting = setTimeout(run, player.cycle ? REST : 0);
}

/** Lets the worker solve a datasheet. */
function ask(request) {
  listen();
  find("solve").disabled = true;
  laboratory.sheet = null;
  worker.postMessage({ kind: "datasheet", request });
}

function showSheet({ text }) {
  clearTimeout(watchdog);
  find("solve").disabled = false;
  if (sheet.show(text)) renew();
  laboratory.sheet = text;
}

function run() {
  worker ??= engine(receive, fail);
  listen();
  worker.postMessage({ kind: "run", scene: number, values: scene.changed });
}

/** Replaces a worker that does not answer. */
function listen() {
  clearTimeout(watchdog);
  watchdog = setTimeout(() => {
    worker.terminate();
    worker = engine(receive, fail);
    fail(say("too_long"));
  }, LOST);
}

/** A worker with the engine in it. */
function engine(heard, failed) {
  const source = new Blob([find("worker").textContent], { type: "text/javascript" });
  const made = new Worker(URL.createObjectURL(source));
  made.onmessage = ({ data }) => heard(data);
  made.onerror = ({ message }) => failed(message);
  const text = atob(find("engine").textContent.trim()), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const { guid, variables } = description;
  made.postMessage({ kind: "open", bytes: bytes.buffer, description: { guid, variables } }, [bytes.buffer]);
  return made;
}

function receive(data) {
  if (data.kind === "bits") laboratory.answer(data.lines);
  if (data.kind === "datasheet") showSheet(data);
  if (["bits", "datasheet"].includes(data.kind) || (data.scene !== undefined && data.scene !== number)) return;
  if (data.kind === "failed") fail(data.text);
  if (data.kind === "blows") showBlows(data);
  if (data.kind === "cycle") showCycle({ ...data,
      stress: data.stress.map((block) => samplesOf(block, data.time.length)) });
}

/** The rows of a block, one for each of so many samples. */
function samplesOf(block, count) {
  const long = block.length / count;
  return Array.from({ length: count }, (_, i) => block.subarray(i * long, (i + 1) * long));
}

function fail(text) {
  clearTimeout(watchdog);
  find("solve").disabled = false;
  Object.assign(find("status"), { textContent: text, className: "failed" });
  laboratory.failure = text;
}

function showBlows({ rows, time, stalled, warnings, done }) {
  if (done) clearTimeout(watchdog);
  else listen();
  laboratory.failure = null;
  blows = laboratory.blows = rows;
  const ghost = past.ghost();
  charts.settle(rows, ghost?.rows);
  showNumbers(rows.at(-1), ghost?.rows.at(-1));
  const still = stalled ? ` ${say("has_stalled")}` : "";
  const text = done ? say("blows_done", { blows: rows.length, time: digits(time, 3) }) + still : say("running",
      { time: digits(time, 2) });
  // Announced once at the end, since a screen reader need not hear every step.
  if (done || find("status").className === "failed") Object.assign(find("status"),
      { textContent: text, className: "" });
  find("warnings").hidden = warnings.length === 0;
  find("warnings").textContent = warnings.join(" ");
  find("blow").max = Math.max(1, rows.length - 1);
  if (done && rows.length < 3) laboratory.settled = true;
}

/** Numbers of a blow: the element's name, whether it exists, its value in SI units, and how that is written. */
const NUMBERS = [
  ["rate", (blow) => blow.rop > 0, (blow) => blow.rop, (v) => `${digits(3600 * v)} m/h (${band(3600 * v)})`],
  ["tip_rate", (blow) => blow.blow_period > 0, (blow) => blow.tip_rate,
      (v) => `${digits(60 * v)} m/min (${digits(1e3 * v)} mm/s)`],
  ["frequency", (blow) => blow.blow_period > 0, (blow) => 1 / blow.blow_period, (v) => `${digits(v)} Hz`],
  ["energy", () => true, (blow) => blow.blow_energy, (v) => `${digits(v)} J`],
  ["speed", () => true, (blow) => blow.blow_speed, (v) => `${digits(v)} m/s`],
  ["penetration", (blow) => blow.blow_period > 0, (blow) => blow.blow_penetration, (v) => `${digits(1e3 * v)} mm`],
  ["air", (blow) => blow.air_flow > 0, (blow) => blow.air_flow, (v) => `${digits(60 * v)} m³/min`],
];

/** The range of a rate, from the uncertainty of the rock's specific energy. */
function band(rate) {
  const factor = scene.get("rock.specific_energy_factor");
  return [rate / factor, rate * factor].map((side) => digits(Number(side.toPrecision(2)))).join("–");
}

/** Shows the last blow, and its difference from that of the previous setting. */
function showNumbers(last, before) {
  find("value-air").parentElement.hidden = !(last?.air_flow > 0);
  for (const [name, has, value, text] of NUMBERS) {
    const shown = last && has(last);
    find(`value-${name}`).textContent = shown ? text(value(last)) : "–";
    const part = shown && before && has(before) ? value(last) / value(before) - 1 : NaN;
    const sign = part >= 0 ? "+" : "";
    find(`was-${name}`).textContent = Number.isFinite(part)
        ? `${sign}${digits(Number((100 * part).toFixed(1)))} %` : "";
  }
}

function showCycle(cycle) {
  const first = Math.max(0, cycle.time.findIndex((time) => time >= cycle.impact));
  const gap = scene.get("contact.initial_gap"), base = cycle.tip_depth[first];
  const bodies = measure(scene, cycle);
  // If there is a casing, its shoulder carries a force at the start.
  const cased = cycle.chuck_force.some((force) => force !== 0);
  const travel = cased ? scene.get("chuck.travel") : 0, rods = scene.variable("drill.rods")
      ? scene.get("drill.rods") : 0;
  drawing.show(cycle, bodies, { gap, diameter: scene.get("hole.diameter"), travel, rods });
  waves.show(cycle, bodies, drawing.limit, description.modes);
  player.show(cycle);
  laboratory.cycle = cycle;
  // A single sample is the start, with the hammer at rest.
  if (cycle.time.length > 1) charts.cycle(cycle, base, gap, description.modes, past.ghost());
  if (cycle.last) past.settle(blows, cycle, base);
  find("blow").value = Math.max(1, cycle.blow + 1);
  find("moment-slider").max = cycle.time.length - 1;
  describe(cycle);
  if (cycle.last) laboratory.settled = true;
  picture();
}

/** Describes the charts in words. */
function describe(cycle) {
  const most = (list, by) => digits(Math.max(...list) * by, 3);
  find("loops").setAttribute("aria-label", say("loops_described", { force: most(cycle.rock_force, 1e-3) }));
  const pressed = Math.max(...CHAMBERS.map((name) => Math.max(...cycle[name])));
  find("chambers").hidden = pressed === 0;
  const driven = pressed > 0 ? say("indicator_of_air",
      { pressure: digits(1e-5 * pressed, 3) }) : say("indicator_of_force",
      { force: most(cycle.applied_drive_force, 1e-3) });
  find("indicator").setAttribute("aria-label", driven);
  find("velocity").setAttribute("aria-label", say("velocity_described", { speed: most(cycle.piston_velocity, 1) }));
  const stress = digits(drawing.limit * 1e-6, 3);
  find("hammer").setAttribute("aria-label", say("hammer_described", { stress }));
  find("waves").setAttribute("aria-label", say("waves_described", { stress }));
}

/** The sample under the pointer in the wave diagram, shown as long as it is there. */
let held = null;
function pointAt(index, clicked) {
  held = index;
  if (clicked) {
    play(false);
    player.index = index;
  }
  if (player.cycle) picture();
}

function picture() {
  const { cycle } = player, index = held ?? player.index;
  laboratory.shown = index;
  drawing.draw(index);
  waves.draw(index);
  laboratory.frames += 1;
  if (laboratory.frames === 1) performance.mark("first picture");
  const mode = MODES[description.modes[cycle.rock_mode[index]]][0];
  const force = (name) => `${digits(cycle[name][index] * 1e-3, 3)} kN`;
  const time = fixed((cycle.time[index] - cycle.impact) * 1e3, 3);
  const parts = [
    say(cycle.blow < 0 ? "moment_start" : "moment_after", { time }),
    say(cycle.contact_closed[index] ? "moment_closed" : "moment_open", { force: force("contact_force") }),
    say("moment_rock", { mode, force: force("rock_force") }),
  ];
  const chuck = cycle.chuck_force[index], hangs = (cycle.bit_position[index] - cycle.casing_position[index]) * 1e3,
      out = digits(Math.abs(hangs) < 1e-3 ? 0 : hangs, 3);
  if (drawing.travel) parts.push(say(chuck > 0 ? "moment_shoulder" : chuck < 0 ? "moment_ring" : "moment_hangs",
      { out, force: force("chuck_force").replace("−", "") }));
  find("moment").textContent = parts.join("; ");
  if (document.activeElement !== find("moment-slider")) find("moment-slider").value = index;
}

let before = performance.now();
function animate(now) {
  // A page that was hidden continues at the same sample.
  const seconds = Math.min(0.1, (now - before) / 1000);
  before = now;
  if (player.playing && player.cycle) {
    const before = player.index;
    player.advance(seconds);
    if (player.index !== before && held === null) picture();
  }
  if (isExploring()) explore.advance(seconds);
  requestAnimationFrame(animate);
}

function play(playing) {
  player.playing = playing;
  find("play").textContent = say(playing ? "pause" : "play");
}

function save(name, text, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function setTimeScale() {
  const slowed = 10 ** find("pace").valueAsNumber;
  player.timeScale = 1 / slowed;
  find("slowed").textContent = say("slowed", { times: Number(slowed.toPrecision(2)).toLocaleString(LANGUAGE) });
}

function connect() {
  find("play").addEventListener("click", () => play(!player.playing));
  find("pace").addEventListener("input", setTimeScale);
  find("hurry").addEventListener("change", ({ target }) => (player.hurry = target.checked));
  find("moment-slider").addEventListener("input", ({ target }) => {
    play(false);
    player.index = target.valueAsNumber;
    if (player.cycle) picture();
  });
  find("blow").addEventListener("change", ({ target }) => {
    const blow = Math.max(1, Math.min(blows.length - 1, target.valueAsNumber || 1));
    worker.postMessage({ kind: "cycle", scene: number, blow: blow - 1 });
  });
  const zoom = (whole) => {
    find("whole").setAttribute("aria-pressed", whole);
    find("after").setAttribute("aria-pressed", !whole);
    charts.zoom(whole);
  };
  find("whole").addEventListener("click", () => zoom(true));
  find("after").addEventListener("click", () => zoom(false));
  find("json").addEventListener("click", () => save("scene.json", scene.json(), "application/json"));
  find("ssv").addEventListener("click", () => save("scene.ssv", scene.ssv(), "application/xml"));
  find("copy").addEventListener("click", async () => {
    const done = navigator.clipboard?.writeText(location.href);
    const said = await (done ?? Promise.reject()).then(() => say("copied"), () => say("copy_it_yourself"));
    find("copy").textContent = said;
    setTimeout(() => (find("copy").textContent = say("copy_link")), 2000);
  });
  find("sliders").addEventListener("submit", (event) => event.preventDefault());
  addEventListener("hashchange", visit);
  find("view-explore").addEventListener("click", () => (location.hash = "screen=1"));
  find("view-laboratory").addEventListener("click", () => (location.hash = "laboratory"));
  addEventListener("resize", repaint);
  // A folded panel has no size, so it is drawn when it opens.
  for (const panel of document.querySelectorAll("details.panel")) panel.addEventListener("toggle", repaint);
  find("view-hammer").addEventListener("click", () => {
    location.hash = scene.link() || "laboratory";
    find("datasheet").open = true;
    setTimeout(() => find("sheet").querySelector("input").focus());
  });
  followPalette(repaint);
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  play(!calm);
}

/** Under each figure, buttons that save it. */
function makeSavers() {
  const { motion: displacement, velocity, modes, loops, indicator, rop, frequency, energy } = charts,
      plots = { displacement, velocity, modes, loops, indicator, rop, frequency, energy, curve: curves.plot };
  const drawn = { hammer: (canvas) => drawnOn(drawing, canvas, picture),
      waves: (canvas) => drawnOn(waves, canvas, picture) };
  for (const [id, plot] of Object.entries(plots)) drawn[id] = (canvas) => traced(plot, canvas);
  for (const [id, draw] of Object.entries(drawn)) {
    find(id).after(saver(id, say(find(id).dataset.sayLabel), (kind) => saveFigure(id, kind, find(id), draw)));
  }
  find("screen-save").append(saver("screen", say("screen_chart_label"), (kind) => explore.save(kind)));
}

/** Buttons that save a figure. */
function saver(of, label, saved) {
  const row = Object.assign(document.createElement("span"),
      { className: "small save", textContent: `${say("screen_save")} ` });
  for (const kind of ["SVG", "PNG"]) {
    const button = Object.assign(document.createElement("button"),
        { id: `save-${of}-${kind}`, type: "button", textContent: kind, ariaLabel: `${label}: ${kind}` });
    button.addEventListener("click", () => saved(kind.toLowerCase()));
    row.append(button, " ");
  }
  return row;
}

/** Draws everything again, because the page has another size or other colours. */
function repaint() {
  waves.image = null;
  charts.redraw();
  curves.plot.redraw();
  explore.draw();
  if (player.cycle) picture();
}

const all = [...Object.values(SLIDERS).flat()].filter(([name, { whole }]) => scene.variable(name) && !whole);
const curves = new Curves(scene, find, all, engine);
const explore = new Explore(find, engine, description, scene.presets);
window.explorable = explore;

/** Shows the explanation or the laboratory, depending on the address. */
function visit() {
  // All words of the page are those of one language.
  if (languageNow() !== LANGUAGE) return location.reload();
  const hash = location.hash.slice(1), screen = /^screen=(\d)$/.exec(hash), exploring = isExploring();
  find("explore").hidden = !exploring;
  find("laboratory").hidden = exploring;
  document.body.classList.toggle("exploring", exploring);
  document.title = find("title").textContent = say(exploring ? "title" : "title_laboratory");
  find("view-explore").setAttribute("aria-pressed", exploring);
  find("view-laboratory").setAttribute("aria-pressed", !exploring);
  if (exploring) explore.go(screen ? Number(screen[1]) - 1 : 0);
  else go(hash);
}

/** Returns the named outputs at equal steps, as the engine's exact bits. */
laboratory.ask = (values, step, steps, names) =>
  new Promise((answer) => {
    laboratory.answer = answer;
    worker.postMessage({ kind: "bits", values, step, steps, names });
  });

find("version").textContent = description.version;
find("licences").textContent = find("terms").textContent;
for (const [short, , text] of Object.values(MODES)) {
  const [term, meaning] = [document.createElement("dt"), document.createElement("dd")];
  Object.assign(term, { textContent: short, className: short.toLowerCase() });
  meaning.textContent = say(text);
  find("modes-legend").append(term, meaning);
}
makeControls();
makeSavers();
connect();
setTimeScale();
visit();
requestAnimationFrame(animate);
