// A story of seven steps for someone who has never seen such a hammer.

/** Of each step: title, text (of the last blow), the part of the page it speaks of, the preset and
 * what to do besides. Times are after the impact, or, below zero, before the next one, s; the pace is a power of ten. */
const STORY = [
  {
    title: "A hammer in its hole",
    text: () => "The casing (grey) hangs on the drill string. In it a piston runs up and down, driven by compressed air or water. Below it the bit stands on the rock. Piston, bit and rock are computed; casing and chuck are drawn around them.",
    at: "hammer", preset: "reference", time: -2.2e-2, pace: 2.5,
  },
  {
    title: "The piston falls",
    text: (blow) => `The pressure drives the piston down. It arrives at ${digits(blow.blow_speed, 3)} m/s with ${digits(blow.blow_energy, 3)} J: as much as a stone of 10 kg that fell ${digits(blow.blow_energy / 98.1, 2)} m. This happens ${digits(1 / blow.blow_period, 2)} times a second.`,
    at: "hammer", preset: "reference", time: -1.2e-2, pace: 2.2,
  },
  {
    title: "The blow",
    text: () => "Piston and bit touch. Where they touch the steel is compressed (blue), and the compression runs away from there as two waves, up the piston and down the bit, at five kilometres a second. The piston’s wave comes back from its free upper end, and the contact opens again: the whole blow is over in less than a tenth of a millisecond.",
    at: "waves", preset: "reference", time: 0, pace: 5,
  },
  {
    title: "Waves in the bit",
    text: () => "The rock takes a part of the wave. The rest returns up the bit, turns around at its upper end and comes again: steep lines in this diagram. Red is tension, which is what breaks steel in the long run. Point at the diagram to read the stress and see the hammer at that moment.",
    at: "waves", preset: "reference", time: 5e-5, pace: 4.8,
  },
  {
    title: "The rock breaks",
    text: (blow) => `Force against depth: the bit presses into the rock, the rock breaks, and springs back a little. The area of the loop is the work that the rock keeps. This blow left the hole ${digits(1e3 * blow.blow_penetration, 2)} mm deeper. The colours are the modes of the rock, which are explained below the picture.`,
    at: "loops", preset: "reference", time: 0, pace: 4.2,
  },
  {
    title: "Harder rock",
    text: (blow) => `The same hammer on granite. Grey is the setting before: the force is higher, and the same blow gains less, ${digits(1e3 * blow.blow_penetration, 2)} mm. Move any slider to compare as well; Undo takes you back.`,
    at: "loops", preset: "granite", time: 0, pace: 4.2,
  },
  {
    title: "A hole through three rocks",
    text: () => "A 3-inch hammer drills through soft, medium and hard rock, many times faster than in reality. Move the feed and the drive while it drills, and see what the log says.",
    at: "drill-feed", preset: "hammer_3_inch", time: 0, pace: 4.2, drill: true,
  },
];

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
    const { find, stage } = this, { title, text, at, preset, time, pace, drill } = STORY[step];
    this.step = step;
    find("story").hidden = false;
    find("story-title").textContent = `${step + 1} of ${STORY.length}: ${title}`;
    find("story-text").textContent = "";
    find("story-back").disabled = step === 0;
    find("story-next").textContent = step === STORY.length - 1 ? "Done" : "Next";
    find("story-next").focus({ preventScroll: true });
    this.point(find(at));
    stage.preset(preset);
    const blow = await stage.settled();
    if (this.step !== step) return;
    find("story-text").textContent = text(blow);
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
