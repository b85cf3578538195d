// The scene: what the description says of each variable, and what the sliders change.

/** The parts of the FMU's description that the page needs. */
function readDescription(text) {
  const root = new DOMParser().parseFromString(text, "application/xml").documentElement;
  const units = {};
  for (const unit of root.querySelectorAll("UnitDefinitions > Unit")) {
    const displays = [...unit.querySelectorAll("DisplayUnit")];
    units[unit.getAttribute("name")] = Object.fromEntries(
      displays.map((other) => [other.getAttribute("name"), Number(other.getAttribute("factor"))]),
    );
  }
  const enumerations = {};
  for (const type of root.querySelectorAll("TypeDefinitions > SimpleType:has(Item)")) {
    const items = [...type.querySelectorAll("Item")].map((item) => [Number(item.getAttribute("value")),
        item.getAttribute("name")]);
    enumerations[type.getAttribute("name")] = Object.fromEntries(items);
  }
  const variables = {};
  for (const element of root.querySelectorAll("ModelVariables > ScalarVariable")) {
    const [kind, get] = [element.firstElementChild, (name) => element.getAttribute(name)];
    const start = kind.getAttribute("start");
    const [unit, displayUnit] = [kind.getAttribute("unit"), kind.getAttribute("displayUnit")];
    variables[get("name")] = {
      reference: Number(get("valueReference")),
      type: kind.tagName,
      causality: get("causality"),
      description: get("description"),
      start: start === null ? null : Number(start),
      min: Number(kind.getAttribute("min") ?? -Infinity),
      max: Number(kind.getAttribute("max") ?? Infinity),
      unit: unit ?? "1",
      displayUnit: displayUnit ?? unit ?? "1",
      factor: displayUnit ? units[unit][displayUnit] : 1,
      items: enumerations[kind.getAttribute("declaredType")],
    };
  }
  return { guid: root.getAttribute("guid"), version: root.getAttribute("version"), variables,
      modes: enumerations.RockMode };
}

/** A unit as people write it. */
function pretty(unit) {
  return unit === "1" ? "" : unit.replace(".", "·").replace(/2(?=\/|$)/, "²").replace(/3(?=\/|$)/, "³");
}

/** A number as the reader's language writes it. */
const written = (number, options) => new Intl.NumberFormat(LANGUAGE,
    { useGrouping: false, ...options }).format(number).replace("-", "−");

/** A number with so many significant digits, with an exponent only if it is very small or large. */
function digits(number, many = 4) {
  if (!Number.isFinite(number)) return "–";
  const size = Math.abs(Number(number.toPrecision(many)));
  const notation = size !== 0 && (size < 1e-3 || size >= 1e7) ? "scientific" : "standard";
  return written(number, { notation, maximumSignificantDigits: many });
}

/** A number with so many decimals. */
const fixed = (number, many) => written(number, { minimumFractionDigits: many, maximumFractionDigits: many });

/** Values that differ from the engine's start values, and the formats in which they are written. */
class Scene {
  constructor(description, presets) {
    this.description = description;
    this.presets = presets;
    [this.changed, this.loaded] = [{}, {}];
  }

  variable(name) {
    return this.description.variables[name];
  }

  get(name) {
    return this.changed[name] ?? this.variable(name).start;
  }

  /** Sets a value in SI units; the engine checks it. */
  set(name, value) {
    const variable = this.variable(name);
    const settable = variable && ["parameter", "input"].includes(variable.causality);
    if (!settable || !Number.isFinite(value)) return false;
    if (value === variable.start) delete this.changed[name];
    else this.changed[name] = value;
    return true;
  }

  replace(values) {
    this.changed = {};
    for (const [name, value] of Object.entries(values)) this.set(name, Number(value));
    this.loaded = { ...this.changed };
  }

  /** The middle of a slider: the value in the loaded hammer, link or sheet; never 0. */
  middle(name) {
    return this.loaded[name] || this.variable(name).start;
  }

  /** The name of the preset with these values, if there is one. */
  preset() {
    const mine = Object.entries(this.changed);
    const same = ({ start_values: values }) =>
      Object.keys(values).length === mine.length && mine.every(([name, value]) => values[name] === value);
    return Object.keys(this.presets).find((name) => same(this.presets[name])) ?? null;
  }

  /** The part of a link after its #. */
  link() {
    return new URLSearchParams(Object.entries(this.changed)).toString();
  }

  follow(link) {
    this.replace(Object.fromEntries(new URLSearchParams(link)));
  }

  /** As a file of the FMU's presets. */
  json() {
    const name = this.preset();
    const text = name ? this.presets[name].description : "A scene of the laboratory";
    return `${JSON.stringify({ description: text, start_values: this.changed }, null, 2)}\n`;
  }

  /** As a parameter set of SSP 1.0, which hosts apply to an FMU. */
  ssv() {
    const kinds = { Real: "Real", Integer: "Integer", Enumeration: "Integer", Boolean: "Boolean" };
    const lines = Object.entries(this.changed).map(
      ([name, value]) =>
        `    <ssv:Parameter name="${name}"><ssv:${kinds[this.variable(name).type]} value="${value}"/>` +
        "</ssv:Parameter>\n",
    );
    return (
      '<?xml version="1.0" encoding="UTF-8"?>\n' +
      '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"' +
      ' version="1.0" name="scene">\n' +
      `  <ssv:Parameters>\n${lines.join("")}  </ssv:Parameters>\n</ssv:ParameterSet>\n`
    );
  }

  /** The preset that needs the fewest changes (null for the start values), and these changes. */
  nearest() {
    const rest = (values) => {
      const there = (name) => values[name] ?? this.variable(name).start;
      const names = new Set([...Object.keys(values), ...Object.keys(this.changed)]);
      return [...names].filter((name) => this.get(name) !== there(name));
    };
    let best = [null, rest({})];
    for (const [name, { start_values: values }] of Object.entries(this.presets)) {
      const names = rest(values);
      if (names.length < best[1].length) best = [name, names];
    }
    return best;
  }

  /** As a command of the Python package. */
  command() {
    const [preset, names] = this.nearest();
    const settings = names.map((name) => {
      const text = `${name}=${this.get(name)}`;
      // Shells would match files by the brackets.
      return ` --set ${text.includes("[") ? `"${text}"` : text}`;
    });
    return `dth-hammer run${preset ? ` ${preset}` : ""}${settings.join("")}`;
  }
}
