// The form of the scene: sliders for the most common variables, sections, and a field for everything else.

const BODIES_GROUP = "group_bodies";
/** The air's pressure, and what a metre of water adds to it, Pa. */
const ATMOSPHERE = 101325, WATER = 9806.65;
/** The variables with a slider, and its range.
 * The middle is the value of the loaded scene. The ends are multiples of it (`parts`, in even steps), or a factor
 * away (`factor`, in even ratios).
 * Otherwise the slider covers the whole domain (`whole`), or goes from a least value, or zero, to a largest.
 * With `water`, a pressure is shown in metres of water.
 * Sliders of one `source` of the drive are hidden with another. */
const SLIDERS = {
  group_drive: [
    ["feed_force", { parts: [0, 2] }],
    ["drive.amplitude", { factor: 3, source: "Relay" }],
    ["drive.stroke", { factor: 3, source: "Relay" }],
    ["supply_pressure", { factor: 2.5, source: "Air" }],
    ["exhaust_pressure", { least: ATMOSPHERE, most: ATMOSPHERE + 100 * WATER, water: true, source: "Air" }],
  ],
  group_rock: [
    ["rock.stiffness", { factor: 10 }],
    ["rock.unloading_ratio", { factor: 3 }],
    ["rock.viscosity", { factor: 5 }],
    ["rock.energy_barrier", { factor: 10 }],
  ],
  group_hole: [
    ["hole.diameter", { most: 0.4 }],
    ["rock.specific_energy", { most: 1e9 }],
  ],
  [BODIES_GROUP]: [
    ["piston.length", { factor: 4 }],
    ["bit.length", { factor: 4 }],
    ["cross_section", { factor: 3 }],
  ],
  group_string: [["drill.rods", { most: 8 }]],
  group_casing: [
    ["casing.mass", { most: 200 }],
    ["casing.impedance", { most: 2e4 }],
    ["chuck.travel", { factor: 4 }],
    ["chuck.idle_travel", { most: 0.05 }],
  ],
  group_mesh: [
    ["piston.elements", { factor: 4 }],
    ["bit.elements", { factor: 4 }],
    ["mesh.degree", { whole: true }],
  ],
};
/** Half the steps of a slider. */
const STEPS = 100;

/** Value at a slider's place from -1 to 1. */
function valueAt(name, { parts, factor, whole, least = 0, most, water }, place) {
  const { type, min, max } = scene.variable(name), middle = scene.middle(name);
  if (most) {
    const value = least + 0.5 * (place + 1) * (most - least);
    return type === "Real" ? Number(value.toPrecision(water ? 6 : 3)) : Math.round(value);
  }
  if (whole) return Math.round(min + ((max - min) * (place + 1)) / 2);
  if (place === 0) return middle;
  const value = parts
    ? middle * (1 + place * (place < 0 ? 1 - parts[0] : parts[1] - 1))
    : middle * factor ** place;
  return type === "Real" ? Number(value.toPrecision(3)) : Math.max(1, Math.round(value));
}

/** The slider's place for a value; its nearest end for a value beyond the range. */
function placeOf(name, { parts, factor, whole, least = 0, most }, value) {
  const { min, max } = scene.variable(name);
  if (most) return Math.max(-1, Math.min(1, (2 * (value - least)) / (most - least) - 1));
  if (whole) return (2 * (value - min)) / (max - min) - 1;
  const ratio = value / scene.middle(name);
  const place = parts
    ? (ratio - 1) / (ratio < 1 ? 1 - parts[0] : parts[1] - 1)
    : Math.log(ratio) / Math.log(factor);
  return Math.max(-1, Math.min(1, Number.isFinite(place) ? place : -1));
}

/** The source of the scene's drive, by name. */
const sourceNow = () => scene.variable("drive.source").items[scene.get("drive.source")];

function makeSlider(name, range, label = say(name)) {
  const variable = scene.variable(name);
  const row = document.createElement("div");
  row.className = "slider";
  const [slider, exact] = [document.createElement("input"), document.createElement("input")];
  Object.assign(slider, { type: "range", min: -STEPS, max: STEPS, step: 1, id: `slide-${name}` });
  Object.assign(exact, { type: "number", step: "any", id: `exact-${name}` });
  exact.setAttribute("aria-label", `${label}, ${pretty(variable.displayUnit) || say("ratio")}`);
  const text = Object.assign(document.createElement("label"), { htmlFor: slider.id, textContent: label });
  text.title = variable.description;
  const unit = Object.assign(document.createElement("span"),
      { className: "unit", textContent: pretty(variable.displayUnit) });
  row.append(text, slider, exact, unit);
  slider.addEventListener("input", () => change(name, valueAt(name, range, slider.valueAsNumber / STEPS)));
  exact.addEventListener("change", () => change(name, Number((exact.valueAsNumber / variable.factor).toPrecision(12))));
  controls.set(name, () => {
    const value = scene.get(name), scaled = Number((value * variable.factor).toPrecision(6));
    slider.value = Math.round(placeOf(name, range, value) * STEPS);
    exact.value = scaled;
    if (range.water) text.textContent = say("under_water",
        { label, depth: digits(Math.max(0, value - ATMOSPHERE) / WATER, 3) });
    row.hidden = range.source !== undefined && range.source !== sourceNow();
    slider.setAttribute("aria-valuetext", `${scaled} ${pretty(variable.displayUnit)}`);
  });
  return row;
}

/** The fields of a body: its number of sections, their lengths and areas. */
function makeSections(body) {
  const name = `${body}.segments`;
  const set = document.createElement("fieldset");
  const choice = Object.assign(document.createElement("select"), { id: `exact-${name}` });
  for (let count = 0; count <= scene.variable(name).max; count++) {
    choice.append(new Option(count === 0 ? say("uniform") : say(count === 1 ? "one_section" : "sections", { count }),
        count));
  }
  choice.addEventListener("change", () => {
    cut(scene, body, Number(choice.value));
    renew();
  });
  const label = Object.assign(document.createElement("label"), { textContent: `${say(`${body}_shape`)} ` });
  label.append(choice);
  set.append(Object.assign(document.createElement("legend"), { textContent: say(`${body}_sections`) }), label);
  const rows = [];
  for (let number = 1; scene.variable(sectionNames(body, number)[0]); number++) {
    const [ofLength, ofArea] = sectionNames(body, number);
    const row = document.createElement("div");
    row.append(
      makeSlider(ofLength, { factor: 10 }, say(`${body}_section_length`, { number })),
      makeSlider(ofArea, { factor: 3 }, say(`${body}_section_area`, { number })),
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
    set.append(Object.assign(document.createElement("legend"), { textContent: say(title) }));
    // A slider is left out if the engine has no such variable.
    rows.filter(([name]) => scene.variable(name)).forEach((row) => set.append(makeSlider(...row)));
    find("sliders").append(set);
    if (title !== BODIES_GROUP) continue;
    BODIES.filter((body) => scene.variable(`${body}.segments`)).forEach((body) => {
      find("sliders").append(makeSections(body));
    });
  }
  makeRest();
  const own = Object.assign(new Option(say("your_own"), ""), { id: "own", hidden: true });
  const names = Object.keys(scene.presets).sort((a, b) => (b === "reference") - (a === "reference"));
  find("preset").append(...names.map((name) => new Option(name.replaceAll("_", " "), name)), own);
  find("preset").addEventListener("change", ({ target }) => {
    scene.replace(scene.presets[target.value].start_values);
    renew();
  });
}

/** A field for each variable of the description that has no slider, under the first part of its name. */
function makeRest() {
  const groups = new Map();
  for (const [name, { causality }] of Object.entries(description.variables)) {
    if (!["parameter", "input"].includes(causality) || controls.has(name)) continue;
    const group = name.includes(".") ? name.split(".")[0] : "";
    groups.set(group, [...(groups.get(group) ?? []), makeField(name)]);
  }
  for (const [group, fields] of groups) {
    const details = document.createElement("details");
    details.append(Object.assign(document.createElement("summary"), { textContent: group || say("group_single") }),
        ...fields);
    find("rest").append(details);
  }
}

/** A field for a value, or a list where the engine has names for its values. */
function makeField(name) {
  const { description: text, displayUnit, factor, items } = scene.variable(name);
  const field = document.createElement(items ? "select" : "input");
  if (items) field.append(...Object.entries(items).map(([value, word]) => new Option(word, value)));
  else Object.assign(field, { type: "number", step: "any" });
  field.id = `exact-${name}`;
  field.addEventListener("change", () => change(name, Number((Number(field.value) / factor).toPrecision(12))));
  controls.set(name, () => (field.value = items ? scene.get(name) : Number((scene.get(name) * factor).toPrecision(6))));
  return givenRow(field, name, text, displayUnit);
}

/** A field with its name before it and its unit after it. */
function givenRow(field, name, title, unit) {
  const row = Object.assign(document.createElement("div"), { className: "given" });
  const label = Object.assign(document.createElement("label"), { htmlFor: field.id, textContent: name, title });
  row.append(label, field, Object.assign(document.createElement("span"),
      { className: "unit", textContent: pretty(unit) }));
  return row;
}
