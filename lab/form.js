// The form of the scene: sliders for what one turns most, sections, and a field for all the rest.

const BODIES_TITLE = "Piston and bit";
/** What the sliders change. Their middle is the engine's start value; their ends, parts of it
 * (even steps) or a factor away (even ratios). Or they cover the whole domain, or go from nothing to a largest value. */
const SLIDERS = {
  "Feed and drive": [
    ["feed_force", "Feed force", { parts: [0, 2] }],
    ["drive.amplitude", "Driving force", { factor: 3 }],
    ["drive.stroke", "Stroke of the pressure law", { factor: 3 }],
  ],
  Rock: [
    ["rock.stiffness", "Loading stiffness", { factor: 10 }],
    ["rock.unloading_ratio", "Unloading-to-loading stiffness ratio", { factor: 3 }],
    ["rock.viscosity", "Viscosity", { factor: 5 }],
    ["rock.energy_barrier", "Energy barrier", { factor: 10 }],
  ],
  Hole: [
    ["hole.diameter", "Diameter of the hole", { most: 0.4 }],
    ["rock.specific_energy", "Work that breaks a volume of rock", { most: 1e9 }],
  ],
  [BODIES_TITLE]: [
    ["piston.length", "Length of the piston", { factor: 4 }],
    ["bit.length", "Length of the bit", { factor: 4 }],
    ["cross_section", "Cross section of both bodies", { factor: 3 }],
  ],
  "Casing and chuck": [
    ["casing.mass", "Mass of the casing (0: none)", { most: 200 }],
    ["casing.impedance", "Impedance of the drill string above it", { most: 2e4 }],
    ["chuck.travel", "How far the bit can hang out", { factor: 4 }],
    ["chuck.idle_travel", "Hanging out so far, it idles (0: never)", { most: 0.05 }],
  ],
  Mesh: [
    ["piston.elements", "Elements of the piston", { factor: 4 }],
    ["bit.elements", "Elements of the bit", { factor: 4 }],
    ["mesh.degree", "Degree of the mesh", { whole: true }],
  ],
};
/** Half the steps of a slider. */
const STEPS = 100;

/** Value at a slider's place from -1 to 1. */
function valueAt(name, { parts, factor, whole, most }, place) {
  const { start, type, min, max } = scene.variable(name);
  if (most) return Number((0.5 * (place + 1) * most).toPrecision(3));
  if (whole) return Math.round(min + ((max - min) * (place + 1)) / 2);
  if (place === 0) return start;
  const value = parts
    ? start * (1 + place * (place < 0 ? 1 - parts[0] : parts[1] - 1))
    : start * factor ** place;
  return type === "Real" ? Number(value.toPrecision(3)) : Math.max(1, Math.round(value));
}

/** The slider's place for a value; at its ends beyond them. */
function placeOf(name, { parts, factor, whole, most }, value) {
  const { start, min, max } = scene.variable(name);
  if (most) return Math.min(1, (2 * value) / most - 1);
  if (whole) return (2 * (value - min)) / (max - min) - 1;
  const ratio = value / start;
  const place = parts
    ? (ratio - 1) / (ratio < 1 ? 1 - parts[0] : parts[1] - 1)
    : Math.log(ratio) / Math.log(factor);
  return Math.max(-1, Math.min(1, Number.isFinite(place) ? place : -1));
}

function makeSlider(name, label, range) {
  const variable = scene.variable(name);
  const row = document.createElement("div");
  row.className = "slider";
  const [slider, exact] = [document.createElement("input"), document.createElement("input")];
  Object.assign(slider, { type: "range", min: -STEPS, max: STEPS, step: 1, id: `slide-${name}` });
  Object.assign(exact, { type: "number", step: "any", id: `exact-${name}` });
  exact.setAttribute("aria-label", `${label}, ${pretty(variable.displayUnit) || "ratio"}`);
  const text = Object.assign(document.createElement("label"), { htmlFor: slider.id, textContent: label });
  text.title = variable.description;
  const unit = Object.assign(document.createElement("span"), { className: "unit", textContent: pretty(variable.displayUnit) });
  row.append(text, slider, exact, unit);
  slider.addEventListener("input", () => change(name, valueAt(name, range, slider.valueAsNumber / STEPS)));
  exact.addEventListener("change", () => change(name, Number((exact.valueAsNumber / variable.factor).toPrecision(12))));
  controls.set(name, () => {
    const value = scene.get(name), scaled = Number((value * variable.factor).toPrecision(6));
    slider.value = Math.round(placeOf(name, range, value) * STEPS);
    exact.value = scaled;
    slider.setAttribute("aria-valuetext", `${scaled} ${pretty(variable.displayUnit)}`);
  });
  return row;
}

/** How many sections a body has, and their lengths and areas. */
function makeSections(body) {
  const name = `${body}.segments`;
  const set = document.createElement("fieldset");
  const choice = Object.assign(document.createElement("select"), { id: `exact-${name}` });
  for (let count = 0; count <= scene.variable(name).max; count++) {
    if (count !== 1) choice.append(new Option(count === 0 ? "uniform" : `${count} sections`, count));
  }
  choice.addEventListener("change", () => {
    cut(scene, body, Number(choice.value));
    renew();
  });
  const label = Object.assign(document.createElement("label"), { textContent: `Shape of the ${body} ` });
  label.append(choice);
  const title = body === "piston" ? "Sections of the piston, from its top" : "Sections of the bit, from its top";
  set.append(Object.assign(document.createElement("legend"), { textContent: title }), label);
  const rows = [];
  for (let number = 1; scene.variable(sectionNames(body, number)[0]); number++) {
    const [ofLength, ofArea] = sectionNames(body, number);
    const row = document.createElement("div");
    row.append(
      makeSlider(ofLength, `Length of section ${number} of the ${body}`, { factor: 10 }),
      makeSlider(ofArea, `Cross section ${number} of the ${body}`, { factor: 3 }),
    );
    rows.push(row);
  }
  set.append(...rows);
  controls.set(name, () => {
    const count = scene.get(name);
    choice.value = count;
    rows.forEach((row, i) => (row.hidden = i >= count));
    find(`slide-${body}.length`).closest(".slider").hidden = count > 0;
    const area = find("slide-cross_section").closest(".slider");
    area.hidden = BODIES.every((other) => scene.get(`${other}.segments`) > 0);
    area.parentElement.hidden = area.hidden;
  });
  return set;
}

function makeControls() {
  for (const [title, rows] of Object.entries(SLIDERS)) {
    const set = document.createElement("fieldset");
    set.append(Object.assign(document.createElement("legend"), { textContent: title }));
    // A slider whose variable the engine no longer has is left out.
    rows.filter(([name]) => scene.variable(name)).forEach((row) => set.append(makeSlider(...row)));
    find("sliders").append(set);
    if (title !== BODIES_TITLE) continue;
    BODIES.filter((body) => scene.variable(`${body}.segments`)).forEach((body) => {
      find("sliders").append(makeSections(body));
    });
  }
  const own = Object.assign(new Option("your own", ""), { id: "own", hidden: true });
  const names = Object.keys(scene.presets).sort((a, b) => (b === "reference") - (a === "reference"));
  find("preset").append(...names.map((name) => new Option(name.replaceAll("_", " "), name)), own);
  find("preset").addEventListener("change", ({ target }) => choose(target.value));
}

