// The FMU of this page: its C functions, compiled to WebAssembly. Runs in the worker.

/** Memory for arguments and results, in pages of 64 KiB. */
const ROOM_PAGES = 4;
/** Offsets in that memory: names and callbacks, value references, values, a handle. */
const TEXT = 0, REFERENCES = 4096, VALUES = 32768, HANDLE = 245760;

/** The standard's status of a log line that is neither a warning nor an error. */
const OK = 0;

/** The logger as a WebAssembly module, because WebAssembly cannot call JavaScript by a pointer. */
const LOGGER = new Uint8Array([
  0x00, 0x61, 0x73, 0x6d, 0x01, 0x00, 0x00, 0x00, // magic, version
  0x01, 0x0a, 0x01, 0x60, 0x06, 0x7f, 0x7f, 0x7f, 0x7f, 0x7f, 0x7f, 0x00, // type: six i32, no result
  0x02, 0x07, 0x01, 0x01, 0x68, 0x01, 0x6c, 0x00, 0x00, // import h.l
  0x07, 0x05, 0x01, 0x01, 0x6c, 0x00, 0x00, // export it again as l
]);

/** The library, with memory of our own in its memory. */
class Library {
  constructor(bytes) {
    this.functions = new WebAssembly.Instance(new WebAssembly.Module(bytes), {}).exports;
    // The library's allocator uses only what it has grown itself, so these pages remain ours.
    this.room = this.functions.memory.grow(ROOM_PAGES) * 65536;
    /** Log lines since the last call of `take`: [status, text]. */
    this.lines = [];
    this.logger = this.plant();
  }

  /** Puts a function that C can call into the library's table, and returns its index. */
  plant() {
    // The text is a format without arguments, so each "%" is doubled in it.
    const listen = (_environment, _name, status, _category, format, _rest) => {
      this.lines.push([status, this.string(format).replaceAll("%%", "%")]);
    };
    const wrapped = new WebAssembly.Instance(new WebAssembly.Module(LOGGER), { h: { l: listen } });
    const table = this.functions.__indirect_function_table;
    const place = table.grow(1);
    table.set(place, wrapped.exports.l);
    return place;
  }

  // Views are made at each use, since the memory's buffer changes when it grows.
  view() {
    return new DataView(this.functions.memory.buffer);
  }

  string(address) {
    const bytes = new Uint8Array(this.functions.memory.buffer, address);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  write(text, address) {
    const bytes = new TextEncoder().encode(`${text}\0`);
    new Uint8Array(this.functions.memory.buffer, address, bytes.length).set(bytes);
    return address;
  }

  /** The engine's answer to a datasheet: see src/datasheet.rs. */
  datasheet(request) {
    const [text, answer] = [this.write(request, this.room + REFERENCES), this.room + VALUES];
    const length = this.functions.dth_datasheet(text, answer, HANDLE - VALUES);
    return new TextDecoder().decode(new Uint8Array(this.functions.memory.buffer, answer, length).slice());
  }

  /** Returns the warnings since the last call. */
  take() {
    // Errors are included, the engine's notes are not.
    return this.lines.splice(0).filter(([status]) => status !== OK).map(([, text]) => text);
  }
}

/** Message for a value that a whole-number variable refuses. */
function refusal(name, { min, max }, value) {
  const range = Number.isFinite(min) && Number.isFinite(max) ? ` from ${min} to ${max}` : "";
  return `${name} = ${value} is refused: it must be a whole number${range}.`;
}

/** One hammer: an instance of the FMU. */
class Hammer {
  /** Takes the result of `readDescription`, and values by name in SI units. */
  constructor(library, description, values) {
    this.library = library;
    this.functions = library.functions;
    this.variables = description.variables;
    const room = library.room + TEXT;
    const callbacks = room + 1024;
    const words = [library.logger, 0, 0, 0, 0]; // log, allocate, free, step finished, environment
    words.forEach((word, i) => library.view().setUint32(callbacks + 4 * i, word, true));
    const [name, guid] = [library.write("laboratory", room), library.write(description.guid, room + 512)];
    this.handle = this.functions.fmi2Instantiate(name, 1, guid, 0, callbacks, 0, 1);
    if (this.handle === 0) throw this.failure("no instance");
    try {
      this.do("fmi2SetupExperiment", 0, 0, 0, 0, 0);
      this.set(values);
      this.do("fmi2EnterInitializationMode");
      this.do("fmi2ExitInitializationMode");
    } catch (error) {
      this.free();
      throw error;
    }
    this.time = 0;
  }

  failure(what) {
    return new Error(this.library.take().pop() ?? what);
  }

  do(name, ...rest) {
    const status = this.functions[name](this.handle, ...rest);
    if (status !== 0) throw this.failure(`${name} failed`);
  }

  set(values) {
    const { room } = this.library;
    for (const [name, value] of Object.entries(values)) {
      const variable = this.variables[name];
      if (variable === undefined) throw new Error(`there is no variable ${name}`);
      const real = variable.type === "Real";
      const view = this.library.view();
      view.setUint32(room + REFERENCES, variable.reference, true);
      // Conversion to 32 bits would drop high bits and fractions.
      if (!real && value !== (value | 0)) throw new Error(refusal(name, variable, value));
      if (real) view.setFloat64(room + VALUES, value, true);
      else view.setInt32(room + VALUES, value, true);
      this.do(real ? "fmi2SetReal" : "fmi2SetInteger", room + REFERENCES, 1, room + VALUES);
    }
  }

  advance(to) {
    this.do("fmi2DoStep", this.time, to - this.time, 0);
    this.time = to;
  }

  /** Reals by value reference. */
  reals(references) {
    return this.read("fmi2GetReal", references, Float64Array);
  }

  /** Integers, or Booleans as 0 and 1, by value reference. */
  integers(references, call = "fmi2GetInteger") {
    return this.read(call, references, Int32Array);
  }

  /** Stresses in the elements of piston (0) or bit (1): see src/abi/browser.rs. */
  stress(body) {
    const { room, functions } = this.library;
    const count = functions.dth_stress(this.handle, body, room + VALUES, (HANDLE - VALUES) / 8);
    return new Float64Array(functions.memory.buffer, room + VALUES, count).slice();
  }

  read(call, references, Kind) {
    const { room, functions } = this.library;
    const memory = () => functions.memory.buffer;
    new Uint32Array(memory(), room + REFERENCES, references.length).set(references);
    this.do(call, room + REFERENCES, references.length, room + VALUES);
    return new Kind(memory(), room + VALUES, references.length).slice();
  }

  /** The state, into a new handle or the one given. */
  keep(state = 0) {
    const place = this.library.room + HANDLE;
    this.library.view().setUint32(place, state, true);
    this.do("fmi2GetFMUstate", place);
    return [this.library.view().getUint32(place, true), this.time];
  }

  restore([state, time]) {
    this.do("fmi2SetFMUstate", state);
    this.time = time;
  }

  forget([state]) {
    const place = this.library.room + HANDLE;
    this.library.view().setUint32(place, state, true);
    this.do("fmi2FreeFMUstate", place);
  }

  free() {
    this.functions.fmi2FreeInstance(this.handle);
  }
}
