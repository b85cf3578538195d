// The wave diagram of a blow: place downward, time to the right, stress as colour.

/** The time shown around the impact, s: as long as waves are sampled (see worker.js). */
const WAVES_FROM = -3e-5, WAVES_UNTIL = 5.9e-4;

class WaveDiagram extends Drawing {
  /** Draws on a canvas.
   * Calls `pointed` with the sample under the pointer (null when it leaves), and whether it was clicked. */
  constructor(canvas, text, pointed) {
    super(canvas.getContext("2d"));
    Object.assign(this, { canvas, told: text });
    const at = (event) => this.point(event.offsetX, event.offsetY);
    const tell = (event, clicked) => {
      const found = this.cycle && at(event);
      this.told.textContent = found ? found.text : "";
      pointed(found ? found.index : null, clicked && Boolean(found));
    };
    canvas.addEventListener("pointermove", (event) => tell(event, event.buttons > 0));
    canvas.addEventListener("pointerdown", (event) => tell(event, true));
    canvas.addEventListener("pointerleave", () => {
      this.told.textContent = "";
      pointed(null, false);
    });
  }

  /** Takes a cycle, what its bodies measure, the largest stress, and names of the rock's modes. */
  show(cycle, bodies, limit, modes) {
    Object.assign(this, { cycle, bodies, limit, modes, image: null });
    this.length = bodies[0].length + bodies[1].length;
  }

  frame() {
    const [width, height, scale] = fit(this.canvas);
    return { left: 50, right: width - 8, top: 4, bottom: height - 50, height, scale };
  }

  x(time, { left, right }) {
    return left + ((time - WAVES_FROM) / (WAVES_UNTIL - WAVES_FROM)) * (right - left);
  }

  /** The sample and the place under a point of the canvas. */
  point(x, y) {
    const frame = this.frame();
    const part = (x - frame.left) / (frame.right - frame.left);
    const place = ((y - frame.top) / (frame.bottom - frame.top)) * this.length;
    if (part < 0 || part > 1 || place < 0 || place >= this.length) return null;
    const time = WAVES_FROM + part * (WAVES_UNTIL - WAVES_FROM);
    const index = this.sample(time);
    const body = place < this.bodies[0].length ? 0 : 1;
    const below = place - (body ? this.bodies[0].length : 0);
    const stress = this.cycle.stress[body][index][this.element(body, below)] ?? 0;
    const values = { time: digits(1e3 * time, 3), place: digits(1e3 * below, 3), stress: digits(1e-6 * stress, 3) };
    return { index, text: say(`pointed_at_${BODIES[body]}`, values) };
  }

  /** The last sample at a time after the impact, or the first. */
  sample(time) {
    const { time: times, impact } = this.cycle;
    let [low, high] = [0, times.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= impact + time) low = middle;
      else high = middle;
    }
    return low;
  }

  element(body, place) {
    const { ends } = this.bodies[body];
    return Math.min(ends.length - 2, ends.findLastIndex((end) => end <= place));
  }

  draw(index) {
    if (!this.cycle) return;
    const frame = this.frame(), { pen } = this;
    this.image ??= this.paint(frame);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.image, frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
    this.axes(frame);
    const now = this.cycle.time[index] - this.cycle.impact;
    if (now < WAVES_FROM || now > WAVES_UNTIL) return;
    this.line([[this.x(now, frame), frame.top], [this.x(now, frame), frame.bottom + 10]], palette.ink, 2);
  }

  /** The diagram itself, with one point per pixel of the screen. */
  paint({ left, right, top, bottom, scale }) {
    const size = [right - left, bottom - top].map((length) => Math.max(1, Math.round(length * scale)));
    const image = new ImageData(...size), colours = stressColours(palette.paper);
    const rows = Array.from({ length: size[1] }, (_, row) => {
      const place = ((row + 0.5) / size[1]) * this.length, upper = this.bodies[0].length;
      const body = place < upper ? 0 : 1;
      return [body, this.element(body, place - body * upper)];
    });
    for (let column = 0; column < size[0]; column++) {
      const time = WAVES_FROM + ((column + 0.5) / size[0]) * (WAVES_UNTIL - WAVES_FROM);
      const sample = this.sample(time);
      rows.forEach(([body, element], row) => {
        // A rigid body has no elements, and no stress.
        const stress = this.cycle.stress[body][sample][element] ?? 0;
        const at = 4 * (row * size[0] + column);
        image.data.set(colours[shade(stress / this.limit)], at);
        image.data[at + 3] = 255;
      });
    }
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = size;
    canvas.getContext("2d").putImageData(image, 0, 0);
    return canvas;
  }

  axes(frame) {
    const { pen, cycle } = this, { left, right, top, bottom } = frame;
    pen.font = FONT;
    const contact = top + (this.bodies[0].length / this.length) * (bottom - top);
    this.line([[left, contact], [right, contact]], palette.ink, 1);
    [["piston", 0.5 * (top + contact)], ["bit", 0.5 * (contact + bottom)],
        ["rock", bottom + 6]].forEach(([name, y]) => this.text(say(name), left - 5, y, "right"));
    // Below the bit, the mode of the rock in the colours of the other pictures.
    for (let pixel = left; pixel < right; pixel++) {
      const time = WAVES_FROM + ((pixel - left + 0.5) / (right - left)) * (WAVES_UNTIL - WAVES_FROM);
      const mode = this.modes[cycle.rock_mode[this.sample(time)]];
      pen.fillStyle = MODES[mode][1]();
      pen.fillRect(pixel, bottom + 2, 1.5, 8);
    }
    for (let tick = 0; tick < 6; tick++) this.text(digits(tick / 10), this.x(tick * 1e-4, frame), bottom + 20);
    this.text(say("time_axis"), 0.5 * (left + right), bottom + 38);
  }
}
