// A story of seven steps for someone who has never seen such a hammer.

/** Of each step, whose texts are `story_1_title`, `story_1` and so on: the part of the page it speaks
 * of, the preset and what to do besides. Times are after the impact, or, below zero, before the next one, s; the pace is a power of ten. */
const STORY = [
  { at: "hammer", preset: "reference", time: -2.2e-2, pace: 2.5 },
  { at: "hammer", preset: "reference", time: -1.2e-2, pace: 2.2 },
  { at: "waves", preset: "reference", time: 0, pace: 5 },
  { at: "waves", preset: "reference", time: 5e-5, pace: 4.8 },
  { at: "loops", preset: "reference", time: 0, pace: 4.2 },
  { at: "loops", preset: "granite", time: 0, pace: 4.2 },
  { at: "drill-feed", preset: "hammer_3_inch", time: 0, pace: 4.2, drill: true },
];

/** What the texts say of the last blow. */
const figuresOf = (blow) => ({
  speed: digits(blow.blow_speed, 3), energy: digits(blow.blow_energy, 3), height: digits(blow.blow_energy / 98.1, 2),
  times: digits(1 / blow.blow_period, 2), advance: digits(1e3 * blow.blow_penetration, 2),
});

class Story {
  /** `stage` has: preset(name), settled() (a promise of the last blow), show(time, pace), drill(). */
  constructor(find, stage) {
    Object.assign(this, { find, stage, step: -1 });
    find("story-begin").addEventListener("click", () => this.go(0));
    find("story-next").addEventListener("click", () => this.go(this.step + 1));
    find("story-back").addEventListener("click", () => this.go(this.step - 1));
    find("story-end").addEventListener("click", () => this.end());
    addEventListener("keydown", (event) => event.key === "Escape" && this.step >= 0 && this.end());
  }

  async go(step) {
    if (step < 0 || step >= STORY.length) return this.end();
    const { find, stage } = this, { at, preset, time, pace, drill } = STORY[step];
    this.step = step;
    find("story").hidden = false;
    find("story-title").textContent = say("story_step", { step: step + 1, all: STORY.length, title: say(`story_${step + 1}_title`) });
    find("story-text").textContent = "";
    find("story-back").disabled = step === 0;
    find("story-next").textContent = say(step === STORY.length - 1 ? "done" : "story_next");
    find("story-next").focus({ preventScroll: true });
    this.point(find(at));
    stage.preset(preset);
    const blow = await stage.settled();
    if (this.step !== step) return;
    find("story-text").textContent = say(`story_${step + 1}`, figuresOf(blow));
    stage.show(time, pace);
    if (drill) stage.drill();
  }

  /** Frames what is spoken of, and brings it into sight above the story. */
  point(place) {
    document.documentElement.classList.toggle("telling", Boolean(place));
    document.querySelector(".pointed")?.classList.remove("pointed");
    if (!place) return;
    place.closest("section").classList.add("pointed");
    place.scrollIntoView({ block: "start" });
  }

  end() {
    this.step = -1;
    this.point(null);
    this.find("story").hidden = true;
    this.find("story-begin").focus();
  }
}
