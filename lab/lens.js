// One insert at the bottom of the hole, and which sample of a cycle is shown when.

/** One insert at the hole's bottom, millimetres wide: what a blow gains, and the blows before. */
class Lens {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
  }

  /** Takes a cycle and the depth of the hole at its impact. */
  show(cycle, base, gain) {
    [this.cycle, this.base, this.gain] = [cycle, base, gain];
    let reached = -Infinity;
    /** The deepest place of the tip so far, sample by sample. */
    this.crater = cycle.bit_tip_position.map((tip) => (reached = Math.max(reached, tip - base)));
    const deepest = Math.max(1e-5, reached);
    this.span = [-1.6 * Math.max(deepest, 2 * gain), 1.5 * deepest];
  }

  draw(index) {
    const { pen, cycle, span: [low, high] } = this;
    const [width, height] = fit(this.canvas);
    const y = (place) => ((place - low) / (high - low)) * (height - 22);
    const tip = y(cycle.bit_tip_position[index] - this.base), crater = y(Math.max(0, this.crater[index]));
    const hole = y(cycle.tip_depth[index] - this.base), middle = 0.6 * width;
    // The marks to the left of the hole have 56 pixels at least.
    const round = Math.min(0.26 * width, 0.5 * height, (middle - 56) / 1.25);
    pen.fillStyle = palette.paper;
    pen.fillRect(0, 0, width, height);
    pen.fillStyle = palette.ground;
    pen.fillRect(0, 0, width, height - 22);
    // The hole: as far down as blows have broken it, at most the crater of this one.
    pen.fillStyle = palette.paper;
    pen.fillRect(middle - 1.25 * round, 0, 2.5 * round, Math.max(hole, y(0)));
    this.cracks(middle, crater, round);
    pen.fillStyle = palette.paper;
    this.nose(middle, crater, round);
    pen.fillStyle = palette.casing;
    this.nose(middle, tip, 0.97 * round);
    this.marks(y, middle - 1.25 * round, hole);
    this.scale(width, height, y);
  }

  /** A round nose from above down to a place. */
  nose(middle, tip, round) {
    const { pen } = this;
    pen.beginPath();
    pen.moveTo(middle - round, -5);
    pen.lineTo(middle - round, tip - 0.7 * round);
    pen.quadraticCurveTo(middle - 0.8 * round, tip, middle, tip);
    pen.quadraticCurveTo(middle + 0.8 * round, tip, middle + round, tip - 0.7 * round);
    pen.lineTo(middle + round, -5);
    pen.closePath();
    pen.fill();
  }

  /** Broken rock under the deepest place of the tip: drawn, not computed. */
  cracks(middle, crater, round) {
    const { pen } = this, deep = crater + 0.35 * round;
    pen.strokeStyle = palette.rock;
    pen.lineWidth = 1.2;
    pen.beginPath();
    for (const turn of [-1.15, -0.6, -0.1, 0.45, 1.05]) {
      const side = Math.sin(turn), down = Math.cos(turn);
      pen.moveTo(middle + 0.5 * round * side, crater - 0.2 * round + 0.2 * round * down);
      pen.lineTo(middle + 0.8 * round * side, crater - 0.2 * round + 0.45 * round * down);
      pen.lineTo(middle + 1.1 * round * side, deep - 0.5 * round + 0.6 * round * down);
    }
    pen.stroke();
  }

  /** The hole's bottom now, and after each blow before. */
  marks(y, edge, hole) {
    const { pen } = this;
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.strokeStyle = palette.rock;
    pen.fillStyle = palette.ink;
    pen.lineWidth = 2;
    let free = Infinity;
    for (const [text, at] of [[say("now"), hole], ...[0, 1, 2, 3].map((k) => [k ? `−${k}` : say("before"), y(-k * this.gain)])]) {
      if (at < 8 || free - at < 13) continue;
      free = at;
      pen.beginPath();
      pen.moveTo(edge - 14, at);
      pen.lineTo(edge, at);
      pen.stroke();
      pen.fillText(text, edge - 17, at);
    }
  }

  scale(width, height, y) {
    const { pen } = this, unit = Number((0.4 * this.span[1]).toPrecision(1));
    const long = y(unit) - y(0);
    pen.fillStyle = palette.ink;
    pen.fillRect(width - 9, 6, 3, long);
    pen.textAlign = "right";
    pen.fillText(`${digits(1e3 * unit, 2)} mm`, width - 13, 6 + Math.max(6, 0.5 * long));
    pen.textAlign = "left";
    pen.fillText(say("lens_caption"), 4, height - 10);
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

  /** Shows the first sample at a time after the impact, s, or later. */
  goTo(time) {
    const after = this.cycle.time.findIndex((t) => t >= this.cycle.impact + time);
    this.index = after < 0 ? this.cycle.time.length - 1 : after;
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
