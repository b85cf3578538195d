// Decides when each sample of a cycle is shown.

/** Shows waves at the chosen pace, and flights faster if `hurry` is set. */
class Player {
  constructor() {
    this.index = 0;
    this.playing = true;
    /** Seconds of the hammer per second of the viewer. */
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

  /** Advances by so many of the viewer's seconds. */
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
      // Long steps belong to flights, which are played faster by as much as they are longer.
      const factor = this.hurry ? Math.max(1, step / 2e-6) ** 0.9 : 1;
      const takes = step / (this.timeScale * factor);
      if (takes > this.rest) return;
      this.rest -= takes;
      this.index = next;
    }
  }
}
