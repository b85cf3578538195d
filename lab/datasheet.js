// The form of a datasheet. The engine lists what may be given, and solves the sheet.

/** Field units and their factors from SI units: by the first word of a number's name, else by its unit. */
const FIELD = { rate: [3600, "m/h"], rotation: [60, "1/min"], W: [1e-3, "kW"], N: [1e-3, "kN"], m: [1e3, "mm"],
  "J/m3": [1e-6, "MJ/m3"], Pa: [1e-6, "MPa"], "m3/s": [60, "m3/min"] };

/** Parses an answer into facts by kind, with their fields as texts. */
function readAnswer(text) {
  const facts = { set: [], compared: [], found: [], assumed: [], contradiction: [], error: [] };
  for (const line of text.split("\n").filter((line) => line)) {
    const [kind, ...fields] = line.split("\t");
    facts[kind].push(fields);
  }
  return facts;
}

class DatasheetForm {
  constructor(choices, scene, find, ask) {
    [this.choices, this.scene, this.answer] = [choices, scene, find("sheet-answer")];
    /** The scene to which a hammer's values are applied, and the scene after the last answer. */
    [this.base, this.made] = [null, null];
    this.fields = new Map(choices.map((choice) => [choice.name, this.field(choice, find("sheet"))]));
    find("solve").addEventListener("click", () => ask(this.request()));
    find("sheet").addEventListener("submit", (event) => {
      event.preventDefault();
      ask(this.request());
    });
  }

  field({ name, meaning, field_unit: unit = "", words }, form) {
    const kind = words ? { type: "text" } : { type: "number", step: "any" };
    const input = Object.assign(document.createElement("input"), { ...kind, id: `sheet-${name}` });
    if (words) {
      const list = Object.assign(document.createElement("datalist"), { id: "rocks" });
      list.append(...words.map((word) => new Option(word)));
      form.append(list);
      input.setAttribute("list", list.id);
    }
    const text = { rop: "rate of penetration", od: "outside diameter" }[name] ?? name.replaceAll("_", " ");
    form.append(givenRow(input, text, meaning, unit));
    return input;
  }

  /** The request to the engine, in SI units. */
  request() {
    const now = JSON.stringify(this.scene.changed);
    // The rock of an earlier answer is not the user's, and must not be scaled again.
    if (now !== this.made) this.base = { ...this.scene.changed };
    const given = this.choices.flatMap(({ name, factor, words }) => {
      if (words) return [[name, this.fields.get(name).value.trim()]].filter(([, word]) => word);
      const value = this.fields.get(name).valueAsNumber;
      return Number.isFinite(value) ? [[name, Number((value * factor).toPrecision(12))]] : [];
    });
    return [...given, ...Object.entries(this.base)].map(([name, value]) => `${name}=${value}\n`).join("");
  }

  /** Shows an answer, and applies its hammer to the scene; true if it has one. */
  show(text) {
    const facts = readAnswer(text);
    this.answer.replaceChildren();
    const tell = (className, words) =>
      this.answer.append(Object.assign(document.createElement("p"), { className, textContent: words }));
    facts.error.forEach(([words]) => tell("failed", words));
    if (facts.error.length > 0) return false;
    facts.contradiction.forEach(([words]) => tell("contradiction", words));
    this.table(["sheet_number", "sheet_given", "sheet_solved", "sheet_off"].map((key) => say(key)),
        facts.compared.map(([name, given, solved, unit]) =>
      this.compared(name, Number(given), Number(solved), unit)));
    this.table(["sheet_found", "sheet_value"].map((key) => say(key)),
        facts.found.map((fields) => this.found(...fields)));
    facts.assumed.forEach(([words]) => tell("small", words));
    const inputs = Object.entries(this.base).filter(([name]) => this.scene.variable(name).causality === "input");
    this.scene.replace(Object.fromEntries([...facts.set, ...inputs]));
    this.made = JSON.stringify(this.scene.changed);
    return true;
  }

  /** A solved number in a field unit, with its range if it has one, and only the digits that the range leaves. */
  found(name, value, si, low, high) {
    const [factor, unit] = FIELD[name.split(" ")[0]] ?? FIELD[si] ?? [1, si || "1"], ratio = high / low;
    const range = ratio > 1.05 ? ` (${[low, high].map((side) => digits(factor * side, 2)).join("–")})` : "";
    return [name, `${digits(factor * value, ratio > 1.3 ? 2 : ratio > 1.05 ? 3 : 4)} ${pretty(unit)}${range}`];
  }

  compared(name, given, solved, si) {
    const { field_unit: unit, factor } = this.choices.find((choice) => choice.name === name) ?? { field_unit: si,
        factor: 1 };
    const off = 100 * (solved / given - 1);
    const sign = off < 0 ? "−" : "+";
    return [name.replaceAll("_", " "), `${digits(given / factor)} ${pretty(unit)}`,
        `${digits(solved / factor)} ${pretty(unit)}`,
      `${sign}${fixed(Math.abs(off), 1)} %`];
  }

  table(heads, rows) {
    const table = document.createElement("table");
    const row = (cells, kind) => {
      const line = document.createElement("tr");
      line.append(...cells.map((cell) => Object.assign(document.createElement(kind), { textContent: cell })));
      return line;
    };
    table.append(row(heads, "th"), ...rows.map((cells) => row(cells, "td")));
    this.answer.append(table);
  }
}
