// Earlier settings: undo, and the setting to which the present one is compared.

/** Changes within this time (ms) count as one, since they come from a moving slider. */
const ONE_CHANGE = 700;

class Past {
  /** `go` loads the scene of a link. */
  constructor(scene, find, go) {
    Object.assign(this, { scene, find, go, links: [], place: -1, last: 0, latest: null, before: null, kept: null });
    find("undo").addEventListener("click", () => this.step(-1));
    find("redo").addEventListener("click", () => this.step(1));
    find("keep").addEventListener("click", () => {
      this.kept = this.kept ? null : this.latest;
      go(this.scene.link());
    });
    find("swap").addEventListener("click", () => {
      const other = this.ghost();
      if (this.kept) this.kept = this.latest;
      if (other) go(other.link);
    });
    addEventListener("keydown", (event) => {
      const typing = event.target.matches("input:not([type=range]):not([type=checkbox])");
      if (typing || event.key.toLowerCase() !== "z" || !(event.ctrlKey || event.metaKey)) return;
      event.preventDefault();
      this.step(event.shiftKey ? 1 : -1);
    });
  }

  /** Records the present scene. */
  note() {
    const link = this.scene.link(), now = performance.now();
    if (link !== this.links[this.place]) {
      // A moving slider leaves one entry, not fifty.
      const same = now - this.last < ONE_CHANGE && this.place > 0;
      this.links.splice(same ? this.place : this.place + 1, Infinity, link);
      this.place = this.links.length - 1;
      this.last = now;
    }
    if (this.latest && this.latest.link !== link) this.before = this.latest;
    this.show();
  }

  step(by) {
    const link = this.links[this.place + by];
    if (link === undefined) return;
    this.place += by;
    this.last = 0;
    this.go(link);
  }

  /** Records the result of the present scene: its blows, the last cycle, and the hole's depth before that cycle. */
  settle(rows, cycle, base) {
    this.latest = { link: this.scene.link(), rows, cycle, base };
    this.show();
  }

  /** The result to which the present one is compared, if there is one. */
  ghost() {
    const ghost = this.kept ?? this.before;
    return ghost && ghost.link !== this.scene.link() ? ghost : null;
  }

  show() {
    this.find("undo").disabled = this.place <= 0;
    this.find("redo").disabled = this.place >= this.links.length - 1;
    this.find("keep").disabled = !this.latest;
    this.find("keep").setAttribute("aria-pressed", Boolean(this.kept));
    this.find("keep").textContent = say(this.kept ? "let_a_go" : "keep_a");
    this.find("swap").disabled = !this.ghost();
    this.find("swap").textContent = say(this.kept ? "swap" : "back_to_grey");
    this.find("grey").textContent = this.ghost() ? say(this.kept ? "grey_is_a" : "grey_is_before") : "";
  }
}
