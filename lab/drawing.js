// The hammer in motion: two bars on rock, and the stress along them.

const PISTON = "#b84e00", BIT = "#0069a6", ROCK = "#8c6d31", INK = "#222", PALE = "#f4f1ea";

/** Blue is compression, red tension, white none: part of the largest from -1 to 1. */
function stressColour(part) {
  const ends = part > 0 ? [178, 24, 43] : [33, 102, 172];
  const weight = Math.min(1, Math.abs(part)) ** 0.7;
  return `rgb(${ends.map((end) => Math.round(255 + weight * (end - 255))).join()})`;
}

/** Draws moments of a cycle. */
class Drawing {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  /** Takes a cycle of the scene, what its bodies measure, and the gap at the start. */
  show(cycle, bodies, gap) {
    [this.cycle, this.bodies, this.gap] = [cycle, bodies, gap];
    const largest = (lists) => {
      let most = 0;
      for (const list of lists) for (const value of list) most = Math.max(most, Math.abs(value));
      return most;
    };
    this.limit = Math.max(1e6, ...cycle.stress.map(largest));
    const start = Math.max(0, cycle.time.findIndex((time) => time >= cycle.impact));
    this.base = cycle.hole_depth[start];
    const [piston, bit] = bodies;
    this.widest = Math.max(...piston.areas, ...bit.areas);
    const highest = Math.min(...cycle.piston_position) - this.base - this.gap - piston.length;
    const lowest = Math.max(...cycle.bit_tip_position) - this.base + bit.length;
    this.span = [highest - 0.02 * (lowest - highest), lowest + 0.18 * (lowest - highest)];
  }

  /** Pixels at the screen's own resolution. */
  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const scale = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * scale) || this.canvas.height !== Math.round(height * scale)) {
      this.canvas.width = Math.round(width * scale);
      this.canvas.height = Math.round(height * scale);
    }
    this.context.setTransform(scale, 0, 0, scale, 0, 0);
    return [width, height];
  }

  draw(index) {
    const { context: pen, cycle, bodies } = this;
    const [width, height] = this.fit();
    pen.clearRect(0, 0, width, height);
    const [left, right] = [50, width - 8];
    const [low, high] = this.span;
    const x = (place) => left + ((place - low) / (high - low)) * (right - left);
    const middle = 0.27 * height, half = 0.2 * height;
    const piston = cycle.piston_position[index] - this.gap - this.base - bodies[0].length;
    const tops = [piston, cycle.bit_position[index] - this.base];
    this.rock(x(cycle.hole_depth[index] - this.base + bodies[1].length), right, middle, half);
    const strip = { top: 0.58 * height, bottom: height - 20, left, right };
    this.axis(strip);
    [PISTON, BIT].forEach((colour, body) => {
      const stress = cycle.stress[body][index];
      const edges = Array.from(bodies[body].ends, (end) => x(tops[body] + end));
      // As high as a round bar of that section looks beside the widest.
      const heights = bodies[body].areas.map((area) => 0.7 * half * Math.sqrt(area / this.widest));
      this.bar(edges, stress, middle, heights, colour);
      this.curve(edges, stress, strip, colour);
    });
    this.words(width, middle, half, x(tops[0]), x(tops[1]));
  }

  bar(edges, stress, middle, heights, colour) {
    const pen = this.context;
    stress.forEach((value, i) => {
      pen.fillStyle = stressColour(value / this.limit);
      // A hair wider: no seams between elements.
      pen.fillRect(edges[i], middle - heights[i], edges[i + 1] - edges[i] + 0.5, 2 * heights[i]);
    });
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.beginPath();
    for (const side of [-1, 1]) {
      pen.moveTo(edges[0], middle);
      heights.forEach((height, i) => {
        pen.lineTo(edges[i], middle + side * height);
        pen.lineTo(edges[i + 1], middle + side * height);
      });
      pen.lineTo(edges.at(-1), middle);
    }
    pen.stroke();
  }

  rock(surface, right, middle, half) {
    const pen = this.context;
    pen.fillStyle = "#e8dcc4";
    pen.fillRect(surface, middle - half, right - surface, 2 * half);
    pen.save();
    pen.beginPath();
    pen.rect(surface, middle - half, right - surface, 2 * half);
    pen.clip();
    pen.strokeStyle = ROCK;
    pen.lineWidth = 0.7;
    pen.beginPath();
    for (let at = right - 4 * half; at < right; at += 9) {
      pen.moveTo(at, middle + half);
      pen.lineTo(at + 2 * half, middle - half);
    }
    pen.stroke();
    pen.restore();
    pen.lineWidth = 2;
    pen.strokeStyle = ROCK;
    pen.beginPath();
    pen.moveTo(surface, middle - half);
    pen.lineTo(surface, middle + half);
    pen.stroke();
  }

  axis({ top, bottom, left, right }) {
    const pen = this.context;
    const most = Number((0.8 * this.limit * 1e-6).toPrecision(1));
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of [-most, 0, most]) {
      const y = this.level(value * 1e6, top, bottom);
      pen.strokeStyle = value === 0 ? "#777" : "#ddd";
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(right, y);
      pen.stroke();
      pen.fillStyle = INK;
      pen.fillText(String(value).replace("-", "−"), left - 5, y);
    }
    pen.textAlign = "left";
    pen.fillText("stress (MPa): tension up and red, compression blue", left, bottom + 11);
  }

  level(stress, top, bottom) {
    return 0.5 * (top + bottom) - (stress / this.limit) * 0.48 * (bottom - top);
  }

  curve(edges, stress, { top, bottom }, colour) {
    const pen = this.context;
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.beginPath();
    stress.forEach((value, i) => {
      pen.lineTo(0.5 * (edges[i] + edges[i + 1]), this.level(value, top, bottom));
    });
    pen.stroke();
  }

  words(width, middle, half, piston, bit) {
    const pen = this.context;
    pen.font = "600 13px system-ui, sans-serif";
    pen.textBaseline = "bottom";
    pen.textAlign = "left";
    pen.fillStyle = PISTON;
    pen.fillText("piston", piston, middle - 0.7 * half - 4);
    pen.fillStyle = BIT;
    pen.fillText("bit", bit, middle - 0.7 * half - 4);
    pen.fillStyle = "#6b5220";
    pen.textAlign = "right";
    pen.fillText("rock", width - 10, middle - half - 3);
  }
}

/** Which sample is shown when: waves at the pace asked for, flights fast-forwarded if wanted. */
class Player {
  constructor() {
    this.index = 0;
    this.playing = true;
    /** Seconds of the hammer for one of the viewer. */
    this.timeScale = 2e-4;
    this.hurry = true;
    this.rest = 0;
  }

  show(cycle) {
    this.cycle = cycle;
    this.index = 0;
  }

  /** Moves on by so many of the viewer's seconds. */
  advance(seconds) {
    const { time } = this.cycle;
    this.rest += seconds;
    for (;;) {
      const next = this.index + 1;
      if (next >= time.length) {
        this.index = 0;
        return;
      }
      const step = time[next] - time[this.index];
      // Long steps are flights: they pass as many times faster as they are longer.
      const factor = this.hurry ? Math.max(1, step / 2e-6) ** 0.9 : 1;
      const takes = step / (this.timeScale * factor);
      if (takes > this.rest) return;
      this.rest -= takes;
      this.index = next;
    }
  }
}
